"""Records the viewer as an animated WebP: the bundled capture plays twice while the camera swings around it once.

    .venv/bin/python -m scripts.record_viewer docs/images/viewer.webp

Trains samples/studio with the preview preset (minutes; `--run RUN` takes a finished run instead), serves it, opens
the page in headless Chromium, and takes one screenshot per frame. Time and camera are set for each frame, so that a
slow machine records the same film as a fast one. Needs Chromium.
"""

from __future__ import annotations

import argparse
import io
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from PIL import Image

from benchmarks.viewers.browser import CHROMIUM_HINT, find_chromium, open_browser, open_viewer
from hgs_core import RunConfig, load_manifest, train_scene
from scripts.demo import HOLD_OUT, REPOSITORY, stop

if TYPE_CHECKING:
    from playwright.sync_api import Page

__all__ = ["film", "write_webp"]

_SIZE = (960, 720)  # pixels of the window
_RATE = 15  # frames per second of the film
_PLAYS = 2  # plays of the scene during one swing of the camera
_SWING = 55.0  # CSS pixels that the pointer moves to either side; the viewer turns by 0.006 radians for each
_LIMIT = 3_000_000  # bytes of the file


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="the .webp file to write")
    parser.add_argument("--run", type=Path, help="a finished run of samples/studio (default: train one)")
    parser.add_argument("--camera", default="cam05", help="capture camera from which the film starts")
    parser.add_argument("--quality", type=int, default=60, help="of the WebP, 0 to 100")
    options = parser.parse_args()
    chromium = find_chromium()
    if chromium is None:
        print(CHROMIUM_HINT, file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="hgs-film-") as scratch:
        run = options.run or train_scene(
            REPOSITORY / "samples" / "studio",
            Path(scratch) / "run",
            RunConfig.for_preset("preview", capture={"hold_out": [HOLD_OUT]}),
        )
        frames = list(_recorded(run, Path(scratch) / "home", options.camera, chromium))
    size = write_webp(options.out, frames, options.quality)
    print(f"{options.out}: {len(frames)} frames, {size:,} bytes")
    if size > _LIMIT:
        print(f"larger than {_LIMIT:,} bytes; give a lower --quality", file=sys.stderr)
        return 1
    return 0


def film(page: Page, start: float, end: float) -> Iterator[Image.Image]:
    """Yield the frames of an open, paused viewer page: the scene from `start` to `end` (seconds), `_PLAYS` times."""
    per_play = round((end - start) * _RATE)
    count = per_play * _PLAYS
    left, top = _SIZE[0] / 2, _SIZE[1] / 2
    page.evaluate("() => { window.hgs.quality = 'high'; }")  # a slow machine would draw what moves coarsely
    page.mouse.move(left, top)
    page.mouse.down()
    for number in range(count):
        angle = 2 * math.pi * number / count
        page.mouse.move(left + _SWING * math.sin(angle), top + 0.25 * _SWING * (1 - math.cos(angle)))
        page.evaluate("time => window.hgs.seek(time)", start + (number % per_play) / _RATE)
        yield Image.open(io.BytesIO(page.screenshot(type="png"))).convert("RGB")
    page.mouse.up()


def write_webp(out: Path, frames: list[Image.Image], quality: int) -> int:
    """Write an endless animation and return its size in bytes."""
    out.parent.mkdir(parents=True, exist_ok=True)
    frames[0].save(
        out, save_all=True, append_images=frames[1:], duration=round(1000 / _RATE), loop=0, quality=quality, method=6
    )
    return out.stat().st_size


def _recorded(run: Path, home: Path, camera: str, chromium: str) -> Iterator[Image.Image]:
    manifest = load_manifest(run / "scene")
    command = [sys.executable, "-m", "server.cli", "serve", str(run.resolve()), "--port", "0", "--workers", "0"]
    environment = os.environ | {"HGS_HOME": str(home)}
    server = subprocess.Popen(command, cwd=REPOSITORY, env=environment, stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        address = f"{server.stdout.readline().strip()}?paused=1&camera={camera}"
        with (
            open_browser(chromium) as browser,
            open_viewer(browser, address, width=_SIZE[0], height=_SIZE[1]) as page,
        ):
            yield from film(page, manifest.start, manifest.end)
    finally:
        stop(server)


if __name__ == "__main__":
    sys.exit(main())
