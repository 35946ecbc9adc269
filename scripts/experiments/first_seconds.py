"""What a visitor sees in the first seconds of a scene's page on a slow line: times, and pictures of the page.

    python scripts/experiments/first_seconds.py SCENE --mbit 2 --pictures first

SCENE is a scene folder; the pages are those that scripts/install has built. `--pictures NAME` writes NAME-1000.png, ...
"""

from __future__ import annotations

import argparse
import asyncio
import shutil
import time
from pathlib import Path
from typing import Any

from playwright.async_api import Browser, async_playwright

from server.bench.bench_scene import scene_of
from server.bench.one_scene_server import serving
from server.bench.shaped_line import ShapedLine

SECONDS = (1.0, 1.5, 2.0, 2.5, 3.0)
STATE = "() => { const s = window.hgs?.state; return s ? [s.splats, s.time, s.complete, s.bytes] : null; }"


async def visit(browser: Browser, port: int, mbit: float, name: str | None) -> dict[str, tuple[float, int]]:
    """Open the page; return after how many seconds and bytes of chunks it has a picture, plays, and has all."""
    found: dict[str, tuple[float, int]] = {}
    async with ShapedLine(port, lambda _: mbit * 1e6) as line:
        page = await browser.new_page(viewport={"width": 480, "height": 360})
        begun = time.monotonic()
        await page.goto(f"http://{line.address}/view/bench", wait_until="commit")
        due = list(SECONDS)
        while due or "complete" not in found:
            state: Any = await page.evaluate(STATE)
            now = time.monotonic() - begun
            if state:
                splats, moment, complete, size = state
                for event, there in (("picture", splats), ("playing", (moment or 0) > 0.02), ("complete", complete)):
                    if there:
                        found.setdefault(event, (round(now, 2), size))
            if due and now >= due[0]:
                second = due.pop(0)
                if name is not None:
                    await page.screenshot(path=f"{name}-{round(1000 * second)}.png")
            await asyncio.sleep(0.02)
        await page.close()
    return found


async def run(options: argparse.Namespace) -> None:
    """Visit the page several times; the first visit warms the browser and takes the pictures."""
    async with serving(scene_of(options.scene)) as port, async_playwright() as playwright:
        browser = await playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
        )
        print(await visit(browser, port, options.mbit, options.pictures))
        for _ in range(options.visits):
            print(await visit(browser, port, options.mbit, None))
        await browser.close()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="The first seconds of a scene's page on a slow line.")
    parser.add_argument("scene", type=Path)
    parser.add_argument("--mbit", type=float, default=2.0)
    parser.add_argument("--visits", type=int, default=5)
    parser.add_argument("--pictures", default=None)
    asyncio.run(run(parser.parse_args()))
