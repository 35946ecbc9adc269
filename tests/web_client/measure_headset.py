"""The cost of a headset's frame beside one picture of as many pixels: `python -m tests.web_client.measure_headset`.

Processor time of all of the browser's processes, with SwiftShader, which other work on the machine disturbs little.
In every frame the head moves, so that every frame has a new order; each frame waits for the device.
"""

from __future__ import annotations

import argparse
import math
import statistics
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import sync_playwright

from benchmarks.viewers.browser import find_chromium, open_viewer
from benchmarks.viewers.process_time import descendants_cpu_seconds
from hgs_core.bench.raster.synthetic_scenes import bench_scene
from hgs_core.codec import encode_scene
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.scene.camera import Camera
from tests.web_client.conftest import serving, site_of
from tests.web_client.emulated_headset import FRUSTA, headset_page

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from playwright.sync_api import Browser, Page

    from tests.web_client.conftest import Site

EYE = 1000  # pixels, width and height
FLAGS = ["--no-sandbox", "--ignore-gpu-blocklist", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
FRAMES = """async ({ frames, eyes }) => {
  for (let i = 0; i < frames; i++) {
    headset.device.position.x = 0.002 * i;
    if (headset.frame() !== eyes) throw new Error("a frame was not drawn");
    const { context: gl } = headset.session.renderState.baseLayer;
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits for the device
    await headset.answered();
  }
}"""


PAGE = "async (frames) => { for (let i = 0; i < frames; i++) await hgs.readPixels(); }"
SIDE = round(EYE * math.sqrt(2))  # side of one picture with the pixels of two eyes


def camera() -> Camera:
    """Return the camera of a visitor's left eye at this place."""
    eye = FRUSTA[0]
    f = SIDE / (eye.left + eye.right)
    return Camera("eye", SIDE, SIDE, f, f, f * eye.left, f * eye.up, np.eye(4))


@contextmanager
def published(splats: int) -> Iterator[Site]:
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "bench"
        still = bench_scene(splats, seed=1).static
        assert still is not None
        statics = still.map(lambda array: np.asarray(array, np.float32))
        scene = HybridScene(statics, (Segment(0.0, 0.0, DynamicSplats.empty()),))
        encode_scene(scene, run / "scene", cameras=[camera()], times=np.zeros(1), title="Bench")
        with serving([run], Path(folder)) as (page,):
            yield site_of(page, run / "scene")


@contextmanager
def swiftshader() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=FLAGS)
        yield browser
        browser.close()


def cost(page: Page, script: str, frames: int, **more: object) -> float:
    """Return processor milliseconds of a frame."""
    page.set_default_timeout(600_000)
    page.evaluate(script, {"frames": 2, **more} if more else 2)  # warm-up
    before = descendants_cpu_seconds()
    page.evaluate(script, {"frames": frames, **more} if more else frames)
    return (descendants_cpu_seconds() - before) * 1000 / frames


def cost_of_eyes(site: Site, frames: int, *, eyes: int) -> float:
    side = EYE if eyes == 2 else SIDE
    with swiftshader() as browser, headset_page(browser, site, "", size=(side, side)) as headset:
        headset.page.evaluate("(one) => { headset.oneEye = one; }", eyes == 1)
        headset.enter()
        return cost(headset.page, FRAMES, frames, eyes=eyes)


def cost_of_page(site: Site, frames: int) -> float:
    """Of the page's own picture, drawn as finely as it can be, and read."""
    address = f"{site.page}?paused=1&exact=1&antialiased=1&width={SIDE}&height={SIDE}"
    with swiftshader() as browser, open_viewer(browser, address, width=SIDE, height=SIDE) as page:
        return cost(page, PAGE, frames)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--splats", type=int, default=100_000)
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    kinds: dict[str, Callable[[Site], float]] = {
        "both eyes": lambda site: cost_of_eyes(site, options.frames, eyes=2),
        "one eye of as many pixels": lambda site: cost_of_eyes(site, options.frames, eyes=1),
        "the page's picture of as many pixels": lambda site: cost_of_page(site, options.frames),
    }
    found: dict[str, list[float]] = {kind: [] for kind in kinds}
    with published(options.splats) as site:
        for _ in range(options.rounds):
            for kind, measure in kinds.items():
                found[kind].append(round(measure(site)))
    for kind, times in found.items():
        print(f"{kind}: {statistics.median(times)} ms of {times}")


if __name__ == "__main__":
    main()
