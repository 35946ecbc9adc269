"""Write tests/vectors/pictures: a small scene, and how it looks from some cameras at some times, for other players; and
tests/vectors/magnification.json: views with the four numbers of their magnification; and
tests/vectors/camera_path.json: a camera path with its cameras at some times.

The pictures are the float64 reference backend's of the decoded scene. Run it after a change of the format or of
docs/numerics.md:

    .venv/bin/python -m scripts.make_picture_vectors
"""

from __future__ import annotations

import dataclasses
import json
import math
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image

from hgs_core.codec import decode_scene, encode_scene
from hgs_core.film.camera_path import CameraPath, KeyFrame
from hgs_core.render import rasterize
from hgs_core.render.magnification import magnification
from hgs_core.scene import HybridScene, Segment
from hgs_core.scene.camera import Camera, looking_at
from tests.chirality import letters, views

VECTORS = Path(__file__).resolve().parent.parent / "tests" / "vectors"
OUT = VECTORS / "pictures"
BACKGROUND = (0.1, 0.15, 0.2)
WIDTH, HEIGHT = 160, 120
DURATION = 2.0  # seconds
PLACES = ((-2.0, -3.0, 0.1), (0.5, -4.0, -0.2), (3.0, -2.0, 0.0))  # x and z, world units, and roll, radians


def scene() -> HybridScene[np.ndarray]:
    """Return the letters L and R and an arrow, of which the R rises, turns and fades."""
    still = letters(moving=True)
    dynamic = still.segments[0].dynamic
    motion, rotation = dynamic.motion.copy(), dynamic.rotation.copy()
    motion[:, 1] = (0.0, -0.5, 0.0)  # up: y points down
    motion[:, 2] = (0.0, 0.0, 0.4)
    rotation[:, 1] = (0.0, 0.3, 0.0, 0.2)
    fading = np.full(len(motion), 1.5, np.float32)
    moved = dataclasses.replace(dynamic, motion=motion, rotation=rotation, time_log_precisions=fading)
    return HybridScene(still.static, (Segment(0.0, DURATION, moved),), BACKGROUND)


def cases() -> list[tuple[str, Camera, float, bool, bool]]:
    """Return name, camera, seconds, whether antialiased and whether by the rig's pixels of each picture."""
    front, above = views(WIDTH, HEIGHT)
    # As an eye of a headset: its middle is not where it looks.
    eye = dataclasses.replace(above, name="eye", fx=120.0, fy=110.0, cx=100.5, cy=50.25)
    close = dataclasses.replace(front, name="close", fx=5 * front.fx, fy=5 * front.fy)
    return [
        ("front", front, 1.0, False, False),
        ("front-earlier", front, 0.25, False, False),
        ("above", above, 1.5, False, False),
        ("eye-antialiased", eye, 1.0, True, False),
        ("close-magnified", close, 1.0, False, True),
        ("close-magnified-antialiased", close, 1.0, True, True),
    ]


def rig() -> list[Camera]:
    """Return the cameras of the scene's manifest."""
    return list(views(WIDTH, HEIGHT))


def picture(camera: Camera, seconds: float, *, antialiased: bool, magnified: bool) -> np.ndarray:
    """Return the reference's picture of the scene that lies in OUT, [H, W, 3] from 0 to 1."""
    decoded = decode_scene(OUT).map(lambda array: torch.tensor(array, dtype=torch.float64))
    segment = decoded.segment_at(seconds)
    render = rasterize(
        decoded.static,
        segment.dynamic,
        camera,
        segment.normalised(seconds),
        background=BACKGROUND,
        backend="reference",
        gradients="none",
        antialiased=antialiased,
        rig=rig() if magnified else (),
    )
    rgb: np.ndarray = render.rgb.permute(1, 2, 0).numpy()
    return rgb


def document() -> list[dict[str, Any]]:
    """Return the content of pictures.json."""
    return [
        {
            "picture": f"{name}.png",
            "time": seconds,
            "antialiased": antialiased,
            "magnified": magnified,
            "camera": camera.to_json(),
        }
        for name, camera, seconds, antialiased, magnified in cases()
    ]


def magnifications() -> dict[str, Any]:
    """Return the content of magnification.json: a rig, and views of it with their numbers."""
    cameras = [looking_at((x, 0.3 * x * x, z), (0.0, 0.1, 0.2), roll) for x, z, roll in PLACES]
    of_rig = [
        Camera(f"camera {i}", 640, 480, 500.0 + 50 * i, 480.0, 320.0, 240.0, pose) for i, pose in enumerate(cameras)
    ]
    middle = Camera("between", 1280, 960, 1000.0, 1000.0, 640.0, 480.0, looking_at((0.2, 0.1, -2.0), (0.0, 0.0, 0.0)))
    away = dataclasses.replace(
        middle, name="turned away", world_to_camera=looking_at((0.2, 0.1, -2.0), (3.0, 0.0, -4.0))
    )
    return {
        "rig": [camera.to_json() for camera in of_rig],
        "views": [
            {"camera": view.to_json(), "magnification": magnification(view, of_rig).tolist()}
            for view in (of_rig[0], of_rig[1].scaled(2), middle, away)
        ],
    }


def camera_path() -> dict[str, Any]:
    """Return the content of camera_path.json: a path, and its cameras at some times."""
    path = CameraPath(
        (
            KeyFrame(0.2, (0.5, -1.0, -3.0), (0.0, 0.1, 0.0), 50.0),
            KeyFrame(0.9, (1.5, -0.5, -2.0), (0.2, 0.0, 0.1), 40.0),
            KeyFrame(1.1, (2.5, -0.7, 0.5), (0.1, -0.2, 0.3), 42.5),
            KeyFrame(3.0, (-1.0, -1.5, 2.0), (0.0, 0.3, -0.2), 75.0),
        )
    )
    cameras = [
        (time, path.camera(time, (640, 480), (0.0, -1.0, 0.0))) for time in (0.0, 0.2, 0.3, 0.9, 1.0, 2.0, 2.9, 4.0)
    ]
    return {
        "path": path.to_json(),
        "cameras": [
            {
                "time": time,
                "position": camera.position.tolist(),
                "forward": camera.world_to_camera[2, :3].tolist(),
                "vertical_fov": math.degrees(2 * math.atan(240 / camera.fy)),
            }
            for time, camera in cameras
        ],
    }


def main() -> None:
    shutil.rmtree(OUT, ignore_errors=True)
    encode_scene(scene(), OUT, cameras=rig(), times=np.linspace(0, DURATION, 9), title="Letters")
    for name, camera, seconds, antialiased, magnified in cases():
        shown = picture(camera, seconds, antialiased=antialiased, magnified=magnified)
        rounded = np.rint(np.clip(shown, 0, 1) * 255).astype(np.uint8)
        Image.fromarray(rounded).save(OUT / f"{name}.png", optimize=True)
    (OUT / "pictures.json").write_text(json.dumps(document(), indent=1) + "\n")
    (VECTORS / "camera_path.json").write_text(json.dumps(camera_path(), indent=1) + "\n")
    (VECTORS / "magnification.json").write_text(json.dumps(magnifications(), indent=1) + "\n")


if __name__ == "__main__":
    main()
