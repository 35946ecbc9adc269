"""A headset for the page, and the true views of its eyes, computed from the manifest and the pose alone."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.codec import load_manifest
from hgs_core.scene.camera import Camera
from tests.web_client.conftest import REPOSITORY, Site

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

Doubles = npt.NDArray[np.float64]

IWER = REPOSITORY / "web_client" / "node_modules" / "iwer" / "build" / "iwer.min.js"
SCRIPT = Path(__file__).with_name("emulated_headset.js")

EYES_APART = 0.064  # metres
EYE_HEIGHT = 1.6  # metres, of somebody who stands at the origin
CAPTURE_DISTANCE = 2.5  # metres: the `extent` of a scene that does not say how large it is
NEAR = 0.05  # metres


@dataclass(frozen=True)
class Frustum:
    """The field of an eye: tangents of the angles from straight ahead to the picture's edges."""

    left: float
    right: float
    up: float
    down: float

    def projection(self, near: float = NEAR, far: float = 100.0) -> list[float]:
        """Return the matrix by columns, as of OpenGL's glFrustum."""
        width, height = self.left + self.right, self.up + self.down
        depth = far - near
        return [
            2 / width,
            0,
            0,
            0,
            0,
            2 / height,
            0,
            0,
            (self.right - self.left) / width,
            (self.up - self.down) / height,
            -(far + near) / depth,
            -1,
            0,
            0,
            -2 * far * near / depth,
            0,
        ]


FRUSTA = (Frustum(0.9, 0.6, 0.7, 0.8), Frustum(0.6, 0.9, 0.7, 0.8))
"""Of the left eye and the right: lopsided as those of headsets."""


def quaternion(yaw: float, pitch: float = 0.0) -> tuple[float, float, float, float]:
    """Return x, y, z, w of a head that turns to its left and then looks up, radians."""
    a, b = yaw / 2, pitch / 2
    return (
        math.cos(a) * math.sin(b),
        math.sin(a) * math.cos(b),
        -math.sin(a) * math.sin(b),
        math.cos(a) * math.cos(b),
    )


def rotation(yaw: float, pitch: float = 0.0) -> Doubles:
    """Return the matrix of the same turn."""
    (sa, ca), (sb, cb) = ((math.sin(angle), math.cos(angle)) for angle in (yaw, pitch))
    return np.array([[ca, 0, sa], [0, 1, 0], [-sa, 0, ca]]) @ np.array([[1, 0, 0], [0, cb, -sb], [0, sb, cb]])


class Headset:
    """A page with its scene in an emulated headset."""

    def __init__(self, page: Page, site: Site, size: tuple[int, int]) -> None:
        self.page = page
        self.site = site
        self.width, self.height = size

    def enter(self, label: str = "Show in the headset") -> None:
        """Press the page's button; where it is the emulator hides once it has shown the headset's picture there."""
        self.page.get_by_role("button", name=label).dispatch_event("click")
        self.page.evaluate("() => headset.entered()")
        self.settle(8)  # the page draws six small pictures all round, and reads them
        self.page.evaluate("() => headset.skip(1_000)")  # the backdrop has taken its colours from them

    def look(self, position: tuple[float, float, float], yaw: float = 0.0, pitch: float = 0.0) -> None:
        """Put the head somewhere in the room."""
        self.page.evaluate(
            "([p, q]) => { headset.device.position.set(...p); headset.device.quaternion.set(...q); }",
            [position, quaternion(yaw, pitch)],
        )

    def aim(self, position: Doubles, yaw: float = 0.0, pitch: float = 0.0, hand: str = "right") -> None:
        """Put a controller somewhere in the room, pointing where a head so turned would look."""
        self.page.evaluate(
            "([hand, p, q]) => {"
            " headset.device.controllers[hand].position.set(...p);"
            " headset.device.controllers[hand].quaternion.set(...q); }",
            [hand, [float(x) for x in position], quaternion(yaw, pitch)],
        )

    def press(self, button: str, hand: str = "right") -> None:
        """Press a controller's button for a frame."""
        self.hold(button, hand)
        self.hold(button, hand, down=False)

    def hold(self, button: str, hand: str = "right", *, down: bool = True) -> None:
        """Press a controller's button, or let it go, and run a frame that sees it."""
        self.page.evaluate(
            "([button, hand, value]) => {"
            " headset.device.controllers[hand].updateButtonValue(button, value);"
            " if (headset.session) headset.frame(); if (headset.session) headset.frame(); }",
            [button, hand, int(down)],
        )

    def frame(self) -> int:
        """Run a frame; returns how often splats were drawn in it."""
        return int(self.page.evaluate("() => headset.frame()"))

    def settle(self, frames: int = 3) -> None:
        """Run frames until the order is of where the head is, with the panel gone."""
        self.page.evaluate(
            """async (frames) => {
              headset.frame(); // with the head where it is now
              headset.skip(10_000); // the panel hides
              for (let i = 0; i < frames; i++) {
                headset.frame();
                await headset.answered();
              }
            }""",
            frames,
        )

    def pictures(self) -> tuple[Doubles, Doubles]:
        """Run a frame and return both eyes' pictures, [H, W, 4] from 0 to 1."""
        texts = self.page.evaluate("() => { headset.frame(); return headset.eyes(); }")
        left, right = (
            np.frombuffer(base64.b64decode(text), np.uint8).reshape(self.height, self.width, 4)[::-1] / 255.0
            for text in texts
        )
        return left, right

    def backdrops(self) -> tuple[Doubles, Doubles]:
        """Run a frame and return the pictures of both eyes without splats, panel and arrow, [H, W, 3]."""
        self.page.evaluate("() => { headset.bare = true; }")
        left, right = self.pictures()
        self.page.evaluate("() => { headset.bare = false; }")
        return left[..., :3], right[..., :3]

    def scene_from_room(self, camera: Camera) -> tuple[Doubles, float, Doubles]:
        """Return rotation, scale and shift of the page's placement of a visitor at a camera."""
        manifest = load_manifest(self.site.folder)
        up = np.asarray(manifest.up)
        forward = camera.world_to_camera[2, :3]
        forward = forward - up * (forward @ up)
        forward /= np.linalg.norm(forward)
        turn = np.stack([np.cross(forward, up), up, -forward], axis=1)
        known = manifest.metres_per_unit
        units = manifest.extent / CAPTURE_DISTANCE if known is None else 1 / known
        return turn, units, camera.position - units * turn @ [0, EYE_HEIGHT, 0]

    def cameras(
        self, camera: Camera, position: tuple[float, float, float], yaw: float = 0.0, pitch: float = 0.0
    ) -> tuple[Camera, Camera]:
        """Return the cameras that the eyes are, with the head at a place in the room, after beginning at `camera`."""
        turn, units, shift = self.scene_from_room(camera)
        head = rotation(yaw, pitch)
        eyes = []
        for side, frustum in zip((-0.5, 0.5), FRUSTA, strict=True):
            centre = units * turn @ (np.asarray(position) + head @ [side * EYES_APART, 0, 0]) + shift
            world_to_camera = np.eye(4)
            world_to_camera[:3, :3] = np.diag([1, -1, -1]) @ (turn @ head).T
            world_to_camera[:3, 3] = -world_to_camera[:3, :3] @ centre
            fx = self.width / (frustum.left + frustum.right)
            fy = self.height / (frustum.up + frustum.down)
            eyes.append(
                Camera(
                    "eye",
                    self.width,
                    self.height,
                    fx,
                    fy,
                    fx * frustum.left,
                    fy * frustum.up,
                    world_to_camera,
                    near=NEAR * units,
                )
            )
        return eyes[0], eyes[1]


@contextmanager
def headset_page(
    browser: Browser, site: Site, parameters: str = "paused=1&t=0.4", size: tuple[int, int] = (256, 256)
) -> Iterator[Headset]:
    """Open the page of a scene, with a headset at hand; each eye has a picture of `size`."""
    if not IWER.is_file():
        pytest.skip("the emulated headset is not there: run npm ci in web_client")
    context = browser.new_context(viewport={"width": 800, "height": 500})
    try:
        context.add_init_script(IWER.read_text() + SCRIPT.read_text())
        page = context.new_page()
        problems: list[str] = []
        page.on("pageerror", lambda error: problems.append(str(error)))
        # The emulator only writes down what a frame throws.
        page.on("console", lambda message: problems.append(message.text) if message.type == "error" else None)
        page.goto(f"{site.page}?{parameters}")
        page.wait_for_function("() => window.hgs?.ready.then(() => true)")
        page.evaluate(
            "([size, left, right]) => Object.assign(headset,"
            " { width: size[0], height: size[1],"
            "   projections: { left: new Float32Array(left), right: new Float32Array(right) } })",
            [size, *(frustum.projection() for frustum in FRUSTA)],
        )
        yield Headset(page, site, size)
        assert problems == []
    finally:
        context.close()
