"""What a frame of a headset costs beside one picture of as many pixels: `python -m tests.web_client.measure_headset`.

Processor time of all of the browser's processes, with SwiftShader, which other work on the machine disturbs little.
In every frame the head moves, so that every frame has a new order; each frame waits for the device.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import sync_playwright

from hgs_core.bench.browser import find_chromium
from hgs_core.bench.process_time import descendants_cpu_seconds
from hgs_core.bench.scenes import bench_camera, bench_scene
from hgs_core.codec import encode_scene
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from tests.web_client.conftest import serving, site_of
from tests.web_client.emulated_headset import headset_page

if TYPE_CHECKING:
    from collections.abc import Iterator

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


@contextmanager
def published(splats: int) -> Iterator[Site]:
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "bench"
        still = bench_scene(splats, seed=1).static
        assert still is not None
        statics = still.map(lambda array: np.asarray(array, np.float32))
        scene = HybridScene(statics, (Segment(0.0, 0.0, DynamicSplats.empty()),))
        encode_scene(scene, run / "scene", cameras=[bench_camera(960, 540)], times=np.zeros(1), title="Bench")
        with serving([run], Path(folder)) as (page,):
            yield site_of(page, run / "scene")


def cost(site: Site, frames: int, *, one_eye: bool) -> float:
    """Return processor milliseconds of a frame."""
    # One picture of the same field of view as an eye's, with the pixels of two.
    side = round(EYE * math.sqrt(2)) if one_eye else EYE
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=FLAGS)
        with headset_page(browser, site, "", size=(side, side)) as headset:
            headset.page.set_default_timeout(600_000)
            headset.page.evaluate("(one) => { headset.oneEye = one; }", one_eye)
            headset.enter()
            times = []
            for count in (2, frames):  # the first ones warm up
                before = descendants_cpu_seconds()
                headset.page.evaluate(FRAMES, {"frames": count, "eyes": 1 if one_eye else 2})
                times.append((descendants_cpu_seconds() - before) * 1000 / count)
        browser.close()
    return times[-1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--splats", type=int, default=100_000)
    parser.add_argument("--frames", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    with published(options.splats) as site:
        both, one = [], []
        for _ in range(options.rounds):
            both.append(cost(site, options.frames, one_eye=False))
            one.append(cost(site, options.frames, one_eye=True))
    ratio = statistics.median(both) / statistics.median(one)
    print(json.dumps({"both eyes, ms": both, "one picture, ms": one, "ratio of the medians": round(ratio, 3)}))


if __name__ == "__main__":
    main()
