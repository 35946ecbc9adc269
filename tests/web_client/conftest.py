"""A published scene on a real server, and a real browser."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from PIL import Image

from hgs_core.camera import Camera
from hgs_core.codec import decode_scene, encode_scene, load_manifest
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from scripts.browser_check import CHROMIUM_HINT, find_chromium, open_browser

if TYPE_CHECKING:
    from playwright.sync_api import Browser

REPOSITORY = Path(__file__).resolve().parents[2]
WIDTH, HEIGHT = 320, 200
FRAMES = 31
BACKGROUND = (0.1, 0.2, 0.3)


@dataclass(frozen=True)
class Site:
    """A running server with one scene."""

    address: str  # http://host:port
    page: str  # the scene's page
    scene: HybridScene[np.ndarray]  # as decoded from its chunks
    cameras: tuple[Camera, ...]
    start: float  # seconds
    end: float


def _cameras() -> list[Camera]:
    """Three cameras that look at the origin from the side, from above and askew, with unlike focal lengths.

    Their directions are no simple ratios: on the codec's grid of positions those would give many splats equal depth.
    """
    eyes = {"side": (0.3178, -0.2239, -3.1927), "above": (1.5347, -2.4173, -1.2589), "askew": (-2.0431, 1.1379, 1.9667)}
    cameras = []
    for name, eye in eyes.items():
        roll = 0.6 if name == "askew" else 0.0
        forward = -np.array(eye, float) / np.linalg.norm(eye)
        right = np.cross([0.0, 1.0, 0.0], forward)
        right /= np.linalg.norm(right)
        down = np.cross(forward, right)
        pose = np.eye(4)
        pose[:3, :3] = [np.cos(roll) * right + np.sin(roll) * down, np.cos(roll) * down - np.sin(roll) * right, forward]
        pose[:3, 3] = -pose[:3, :3] @ eye
        cameras.append(Camera(name, WIDTH, HEIGHT, 300.0, 280.0, 170.5, 92.0, pose))
    return cameras


def _scene() -> HybridScene[np.ndarray]:
    """A still cloud, and clouds in two segments of one second that fly, turn, appear and vanish."""
    r = np.random.default_rng(3)

    def single(value: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(value, np.float32)

    def dynamic(count: int) -> DynamicSplats[np.ndarray]:
        motion = np.zeros((count, 4, 3))
        motion[:, 0] = r.uniform(-0.8, 0.8, (count, 3))
        motion[:, 1:] = r.normal(size=(count, 3, 3)) * 0.4
        return DynamicSplats(
            single(motion),
            single(r.normal(size=(count, 2, 4)) * [[[1.0], [0.5]]]),
            single(np.log(r.uniform(0.03, 0.15, (count, 3)))),
            single(r.normal(1.0, 1.5, count)),
            single(r.uniform(0, 1, count)),
            single(r.uniform(-2, 5, count)),
            single(r.uniform(0, 1, (count, 3))),
        )

    count = 2500
    static = StaticSplats(
        single(r.uniform(-1, 1, (count, 3))),
        single(np.log(r.uniform(0.01, 0.12, (count, 3)))),
        single(r.normal(size=(count, 4))),
        single(r.normal(0.0, 2.0, count)),
        single(r.uniform(0, 1, (count, 3))),
    )
    return HybridScene(static, (Segment(0.0, 1.0, dynamic(400)), Segment(1.0, 2.0, dynamic(300))))


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    chromium = find_chromium()
    if chromium is None:
        pytest.skip(CHROMIUM_HINT)
    with open_browser(chromium) as opened:
        yield opened


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """Serve the scene as `hgs serve` does, in a process of its own."""
    if not (REPOSITORY / "server" / "viewer" / "index.html").is_file():
        pytest.skip("the viewer is not built: run npm ci && npm run build in web_client")
    run = tmp_path_factory.mktemp("runs") / "clouds"
    home = tmp_path_factory.mktemp("home")
    thumbnail = BytesIO()
    Image.new("RGB", (64, 40), (90, 60, 120)).save(thumbnail, "JPEG")
    encode_scene(
        _scene(),
        run / "scene",
        cameras=_cameras(),
        times=np.linspace(0.0, 2.0, FRAMES),
        title="Clouds",
        background=BACKGROUND,
        thumbnail=thumbnail.getvalue(),
    )
    manifest = load_manifest(run / "scene")
    command = [sys.executable, "-m", "server.cli", "serve", str(run), "--port", "0", "--workers", "0"]
    log = home / "server.log"
    with log.open("wb") as errors:
        server = subprocess.Popen(
            command,
            cwd=REPOSITORY,
            env=os.environ | {"HGS_HOME": str(home), "PYTHONPATH": str(REPOSITORY)},
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
    try:
        assert server.stdout is not None
        page = server.stdout.readline().strip()
        assert page.startswith("http"), log.read_text()
        address = page.partition("/view/")[0]
        yield Site(address, page, decode_scene(run / "scene"), manifest.cameras, manifest.start, manifest.end)
    finally:
        server.terminate()
        server.communicate(timeout=30)
