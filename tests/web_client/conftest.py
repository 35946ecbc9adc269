"""Published scenes on a real server."""

from __future__ import annotations

import dataclasses
import functools
import http.server
import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from hgs_core.codec import decode_scene, encode_scene, load_manifest
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera, looking_at

pytest.register_assert_rewrite("tests.web_client.asked_of_hosts")

REPOSITORY = Path(__file__).resolve().parents[2]
MODULES = Path(__file__).resolve().parent / "modules"  # the pipelines that tests name
WIDTH, HEIGHT = 320, 200
FRAMES = 31
BACKGROUND = (0.1, 0.2, 0.3)


@dataclass(frozen=True)
class Site:
    """A scene on a running server."""

    address: str  # http://host:port
    page: str  # the scene's page
    scene: HybridScene[np.ndarray]  # decoded chunks
    cameras: tuple[Camera, ...]
    start: float  # seconds
    end: float
    folder: Path  # folder of its manifest and chunks


def _single(value: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(value, np.float32)


def _static(r: np.random.Generator, count: int, scales: np.ndarray) -> StaticSplats[np.ndarray]:
    return StaticSplats(
        _single(r.uniform(-1, 1, (count, 3))),
        _single(np.log(scales)),
        _single(r.normal(size=(count, 4))),
        _single(r.normal(0.0, 2.0, count)),
        _single(r.uniform(0, 1, (count, 3))),
    )


def _dynamic(r: np.random.Generator, count: int, smallest: float, largest: float) -> DynamicSplats[np.ndarray]:
    motion = np.zeros((count, 4, 3))
    motion[:, 0] = r.uniform(-0.8, 0.8, (count, 3))
    motion[:, 1:] = r.normal(size=(count, 3, 3)) * 0.4
    return DynamicSplats(
        _single(motion),
        _single(r.normal(size=(count, 2, 4)) * [[[1.0], [0.5]]]),
        _single(np.log(r.uniform(smallest, largest, (count, 3)))),
        _single(r.normal(1.0, 1.5, count)),
        _single(r.uniform(0, 1, count)),
        _single(r.uniform(-2, 5, count)),
        _single(r.uniform(0, 1, (count, 3))),
    )


def _encode_clouds(out: Path) -> None:
    """A still cloud, and clouds in two segments of one second that fly, turn, come and go; the second by d^5, too.

    Three cameras look at it from the side, from above and askew, with unlike focal lengths. Their directions are no
    simple ratios: on the codec's grid of positions those would give many splats equal depth.
    """
    r = np.random.default_rng(3)
    first, second = _dynamic(r, 400, 0.03, 0.15), _dynamic(r, 300, 0.03, 0.15)
    swings = _single(np.random.default_rng(5).normal(size=(300, 2, 3)) * 4.0)
    second = dataclasses.replace(second, motion=np.concatenate([second.motion, swings], axis=1))
    segments = (Segment(0.0, 1.0, first), Segment(1.0, 2.0, second))
    poses = {
        "side": looking_at((0.3178, -0.2239, -3.1927), np.zeros(3)),
        "above": looking_at((1.5347, -2.4173, -1.2589), np.zeros(3)),
        "askew": looking_at((-2.0431, 1.1379, 1.9667), np.zeros(3), roll=0.6),
    }
    thumbnail = BytesIO()
    Image.new("RGB", (64, 40), (90, 60, 120)).save(thumbnail, "JPEG")
    encode_scene(
        HybridScene(_static(r, 2500, r.uniform(0.01, 0.12, (2500, 3))), segments, BACKGROUND),
        out,
        cameras=[Camera(name, WIDTH, HEIGHT, 300.0, 280.0, 170.5, 92.0, pose) for name, pose in poses.items()],
        times=np.linspace(0.0, 2.0, FRAMES),
        title="Clouds",
        thumbnail=lambda alone: thumbnail.getvalue(),
    )


def _encode_dust(out: Path) -> None:
    """Grains and needles, which most are thinner than a pixel of the camera "far"; said to be trained antialiased.

    Before the camera "close" the needles are a tenth of a pixel thin and a thousand pixels long.
    """
    r = np.random.default_rng(4)
    grains, needles = 4000, 60
    scales = np.exp(r.uniform(np.log(0.003), np.log(0.03), (grains + needles, 3)))
    scales[grains:] = [0.0005, 0.0005, 4.0]
    segment = Segment(0.0, 1.0, _dynamic(r, 500, 0.005, 0.03))
    encode_scene(
        HybridScene(_static(r, grains + needles, scales), (segment,), BACKGROUND, antialiased=True),
        out,
        cameras=[
            Camera("far", 96, 64, 240.0, 240.0, 48.0, 32.0, looking_at((1.1178, -2.2239, -7.5927), np.zeros(3))),
            Camera(
                "close", WIDTH, HEIGHT, 300.0, 300.0, 160.0, 100.0, looking_at((-0.4431, 0.6379, 1.2667), np.zeros(3))
            ),
        ],
        times=np.linspace(0.0, 1.0, FRAMES),
        title="Dust",
    )


@pytest.fixture
def flipped_bit() -> str:
    """Return a script for a page in which one bit of the stream's first chunk arrives wrong."""
    return """
      const Original = WebSocket;
      window.WebSocket = class extends Original {
        constructor(url) {
          super(url);
          const flip = ({ data }) => {
            const bytes = new Uint8Array(data);
            if (bytes[0] !== 1) return;
            bytes[100] ^= 1;
            this.removeEventListener("message", flip);
          };
          this.addEventListener("message", flip);
        }
      };
    """


@contextmanager
def serving(
    runs: list[Path], home: Path, *options: str, workers: int = 0, environment: Mapping[str, str] | None = None
) -> Iterator[list[str]]:
    """Serve the scenes of runs as `hgs serve` does, in a process of its own; yields the addresses of their pages.

    Without a run it is the address of the list.
    """
    if not (REPOSITORY / "server" / "viewer" / "index.html").is_file():
        pytest.skip("the viewer is not built: run npm ci && npm run build in web_client")
    command = [sys.executable, "-m", "server.cli", "serve", *map(str, runs), "--port", "0"]
    command += ["--workers", str(workers), *options]
    path = os.pathsep.join((str(REPOSITORY), str(MODULES)))
    log = home / "server.log"
    with log.open("wb") as errors:
        server = subprocess.Popen(
            command,
            cwd=REPOSITORY,
            env=os.environ | {"HGS_HOME": str(home), "PYTHONPATH": path} | (environment or {}),
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
    try:
        assert server.stdout is not None
        pages = [server.stdout.readline().strip() for _ in runs or [None]]
        assert all(page.startswith("http") for page in pages), log.read_text()
        yield pages
    finally:
        server.terminate()
        server.communicate(timeout=30)


@pytest.fixture(scope="session")
def sites(tmp_path_factory: pytest.TempPathFactory) -> Iterator[list[Site]]:
    """The clouds and the dust, served."""
    folder = tmp_path_factory.mktemp("runs")
    runs = [folder / "clouds", folder / "dust"]
    for run, encode in zip(runs, (_encode_clouds, _encode_dust), strict=True):
        encode(run / "scene")
    with serving(runs, tmp_path_factory.mktemp("home")) as pages:
        yield [site_of(page, run / "scene") for page, run in zip(pages, runs, strict=True)]


def site_of(page: str, folder: Path) -> Site:
    manifest = load_manifest(folder)
    address = page.partition("/view/")[0]
    return Site(address, page, decode_scene(folder), manifest.cameras, manifest.start, manifest.end, folder)


@pytest.fixture(scope="session")
def address(site: Site, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A plain web server with the package as it is built, the engines it is used with, the clouds and the examples."""
    client = REPOSITORY / "web_client"
    npx = shutil.which("npx")
    if npx is None or not (client / "node_modules" / "three").is_dir():
        pytest.skip("needs npm and web_client/node_modules")
    folder = tmp_path_factory.mktemp("host")
    build = [npx, "vite", "build", "-c", "vite.package.config.ts", "--outDir", str(folder / "dist")]
    subprocess.run([*build, "--logLevel", "warn"], cwd=client, check=True, capture_output=True)
    (folder / "node_modules").mkdir()
    for name in ("three", "playcanvas"):
        (folder / "node_modules" / name).symlink_to(client / "node_modules" / name)
    scripts = [(script.name, script) for script in Path(__file__).parent.glob("*_host.js")]
    for name, place in [("examples", client / "examples"), ("clouds", site.folder), *scripts]:
        (folder / name).symlink_to(place)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Files, directory=str(folder))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


class _Files(http.server.SimpleHTTPRequestHandler):
    """A handler without a log."""

    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture(scope="session")
def site(sites: list[Site]) -> Site:
    """Clouds of splats wider than a pixel."""
    return sites[0]


@pytest.fixture(scope="session")
def dust(sites: list[Site]) -> Site:
    """Splats thinner than a pixel, to be drawn with antialiasing."""
    return sites[1]
