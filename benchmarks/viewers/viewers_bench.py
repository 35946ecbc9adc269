"""Our viewer beside others: processor time of a frame and error of the picture, on equal splats in one browser.

A frame is drawn to its end before the next one begins, and its time is that of the browser's processes, so that other
work on the machine does not count. The rounds are interleaved: every viewer once, then every viewer again.
"""

from __future__ import annotations

import base64
import dataclasses
import json
import math
import shutil
import statistics
import tempfile
import urllib.parse
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from numpy.typing import NDArray

from benchmarks.viewers.bench_pages import build_pages, served
from benchmarks.viewers.browser import CHROMIUM_HINT, find_chromium, open_browser, psnr
from benchmarks.viewers.process_time import descendants_cpu_seconds
from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback, silent
from hgs_core.codec import decode_scene, load_manifest
from hgs_core.interchange.export_scene import export_scene
from hgs_core.interchange.still_moment import scene_at
from hgs_core.native.machine import machine_facts
from hgs_core.render import rasterize
from hgs_core.runs.imported import import_run
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

if TYPE_CHECKING:
    from playwright.sync_api import Page

__all__ = ["VIEWERS", "ViewerPoint", "ViewerReport", "bench_viewers"]

VIEWERS = ("hgs", "hgs-8bit", "hgs-budget", "playcanvas", "babylon", "spark", "gaussian-splats-3d")
"""Ours as pages have it, with an 8-bit target, and with the more useful half of the splats; and four others at the
versions of web_client/bench/viewers."""

OURS = ("hgs", "hgs-8bit", "hgs-budget")
DEGREES = (0, 70)
"""Around the scene, where pictures are compared."""

BLACK = (0.0, 0.0, 0.0)
FIELD_OF_VIEW = 50.0  # degrees, vertical
LONGEST_STEP = 600_000  # ms that a phase may take in a browser without a graphics card


@dataclass(frozen=True)
class ViewerPoint:
    """One viewer; times are medians over the rounds, in milliseconds of processor time for each frame."""

    viewer: str
    still: float  # the same picture again
    orbit: float  # the camera turns by 9 degrees a frame, and the splats are ordered anew
    playing: float | None  # playing, for our viewer and moving scenes
    psnr: tuple[float, ...]  # dB against the renderer in float64, at each of `DEGREES`


@dataclass(frozen=True)
class ViewerReport:
    """The results of `bench_viewers`."""

    machine: Mapping[str, Any]
    chromium: str  # its version
    source: str
    splats: int  # splats of every viewer
    size: tuple[int, int]  # width, height
    rounds: int
    frames: int  # frames of a phase
    points: tuple[ViewerPoint, ...]

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        return dataclasses.asdict(self)


def bench_viewers(
    source: Path,
    progress: ProgressCallback,
    *,
    viewers: Sequence[str] = VIEWERS,
    size: tuple[int, int] = (640, 480),
    rounds: int = 3,
    frames: int = 20,
    measured_one: Callable[[ViewerPoint, int], None] = lambda point, done: None,
) -> ViewerReport:
    """Draw a finished run, a scene folder or a file of splats with several viewers in the system's Chromium.

    What is drawn is the scene as HGS decodes it; of a moving scene the other viewers get the splats of its start.
    `measured_one` is called after every measurement with the viewer's figures so far, and of how many rounds they are.

    Raises:
        InputError: the source is neither, a viewer is unknown, or Chromium, Playwright or npm is missing.
    """
    unknown = sorted(set(viewers) - set(VIEWERS))
    if unknown:
        raise InputError("--viewers", f"{unknown[0]} is unknown", f"use some of {', '.join(VIEWERS)}")
    if not source.is_file():
        load_manifest(_scene_folder(source))  # a wrong path is told before the pages are built
    chromium = find_chromium()
    if chromium is None:
        raise InputError("benchmarks.viewers", CHROMIUM_HINT)
    with tempfile.TemporaryDirectory(prefix="hgs-bench-") as scratch:
        pages = Path(scratch) / "pages"
        build_pages(pages)
        scene, camera, splats = _write_files(source, pages / "data", Path(scratch), size)
        truths = {name: _truths(scene, splats, camera, size, ours=name in OURS) for name in viewers}
        measured: dict[str, list[dict[str, Any]]] = {name: [] for name in viewers}
        version = ""
        with served(pages) as address:
            for turn in range(rounds):
                for place, name in enumerate(viewers):
                    with open_browser(chromium) as browser:
                        version = browser.version
                        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
                        query = {"viewer": name, "width": size[0], "height": size[1], "splats": len(splats)}
                        query |= {"camera": json.dumps(camera)}
                        page.goto(f"{address}?{urllib.parse.urlencode(query)}")
                        playing = name in OURS and scene.dynamic_splats > 0
                        measured[name].append(_measure(page, size, frames, playing))
                    measured_one(_point(name, measured[name], truths[name]), turn + 1)
                    progress(Progress("viewers", turn * len(viewers) + place + 1, rounds * len(viewers)))
    points = tuple(_point(name, measured[name], truths[name]) for name in viewers)
    return ViewerReport(machine_facts(), version, str(source), len(splats), size, rounds, frames, points)


def _scene_folder(source: Path) -> Path:
    return RunFolder(source).scene if RunFolder(source).manifest.is_file() else source


def _write_files(
    source: Path, out: Path, scratch: Path, size: tuple[int, int]
) -> tuple[HybridScene[Floats], dict[str, Any], StaticSplats[Floats]]:
    """Write the viewers' files; return the scene, the camera in the page's form, and the splats of the start."""
    if source.is_file():
        import_run(
            source,
            scratch / "run",
            silent,
            duration=1.0,
            capture=None,
            config=RunConfig(preset="imported"),
            antialiased=False,
        )
        source = scratch / "run"
    folder = _scene_folder(source)
    manifest, scene = load_manifest(folder), decode_scene(folder)
    shutil.copytree(folder, out / "scene")
    splats = scene_at(scene, scene.start)
    moment = HybridScene(splats, (Segment(scene.start, scene.start, DynamicSplats.empty()),), BLACK)
    for name in ("scene.ply", "scene.splat"):
        export_scene(moment, out / name, cameras=())
    start = manifest.cameras[0]
    eye = -start.world_to_camera[:3, :3].T @ start.world_to_camera[:3, 3]
    distance = float(np.linalg.norm(eye - manifest.center))
    camera = {
        "eye": [float(x) for x in eye],
        "target": list(manifest.center),
        "up": list(manifest.up),
        "fovY": FIELD_OF_VIEW,
        "near": min(start.near, distance / 20),
        "far": 100 * distance,
    }
    return scene, camera, splats


def _measure(page: Page, size: tuple[int, int], frames: int, playing: bool) -> dict[str, Any]:
    page.set_default_timeout(LONGEST_STEP)
    page.wait_for_function("() => window.bench !== undefined", polling=100)  # frames come on demand alone
    page.evaluate("() => bench.load()")

    def milliseconds(phase: str) -> float:
        began = descendants_cpu_seconds()
        page.evaluate(f"() => bench.{phase}({frames})")
        return (descendants_cpu_seconds() - began) * 1000 / frames

    pictures = []
    times: dict[str, Any] = {phase: milliseconds(phase) for phase in ("still", "orbit")}
    times["playing"] = None
    for degrees in DEGREES:
        pixels = base64.b64decode(page.evaluate(f"() => bench.image({degrees})"))
        pictures.append(np.frombuffer(pixels, np.uint8).reshape(size[1], size[0], 4)[::-1, :, :3])
    if playing:
        times["playing"] = milliseconds("play")
    return times | {"pictures": pictures}


def _point(name: str, rounds: Sequence[Mapping[str, Any]], truths: Sequence[NDArray[np.float64]]) -> ViewerPoint:
    def middle(phase: str) -> float:
        return float(statistics.median(one[phase] for one in rounds))

    errors = tuple(psnr(picture, truth) for picture, truth in zip(rounds[-1]["pictures"], truths, strict=True))
    playing = None if rounds[0]["playing"] is None else middle("playing")
    return ViewerPoint(name, middle("still"), middle("orbit"), playing, errors)


def _truths(
    scene: HybridScene[Floats],
    splats: StaticSplats[Floats],
    camera: Mapping[str, Any],
    size: tuple[int, int],
    ours: bool,
) -> list[NDArray[np.float64]]:
    """Return our renderer's pictures [H, W, 3] at `DEGREES`.

    For our own viewer as the scene is to be drawn; for others without what their formats cannot say, a background and
    antialiasing.
    """
    pictures = []
    for degrees in DEGREES:
        render = rasterize(
            splats.map(torch.from_numpy),
            None,
            turned_camera(camera, degrees, size),
            background=scene.background if ours else BLACK,
            antialiased=ours and scene.antialiased,
            backend="cpu",
            gradients="none",
        )
        pictures.append(np.clip(render.rgb.double().permute(1, 2, 0).numpy(), 0, 1))
    return pictures


def turned_camera(camera: Mapping[str, Any], degrees: float, size: tuple[int, int]) -> Camera:
    """Return the bench's camera, turned about its up axis through its target, for pictures of `size`."""
    target, up = np.asarray(camera["target"]), np.asarray(camera["up"])
    arm = np.asarray(camera["eye"]) - target
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    arm = arm * c + np.cross(up, arm) * s + up * (up @ arm) * (1 - c)
    pose = looking_at(target + arm, target, up=up)
    width, height = size
    focal = 0.5 * height / math.tan(math.radians(camera["fovY"]) / 2)
    return Camera("bench", width, height, focal, focal, width / 2, height / 2, pose, near=camera["near"])
