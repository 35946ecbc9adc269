"""When a scene begins to play from a folder and from a stream, on the same page, server and slow line.

    python scripts/experiments/folder_and_stream.py SCENE --mbit 2 --visits 8

SCENE is a scene folder; the player is that which scripts/install has built. Visits to all take turns: to the folder's
manifest, to its index, over HTTP as well, and to the stream.
"""

from __future__ import annotations

import argparse
import asyncio
import shutil
import tempfile
import time
from pathlib import Path

from fastapi.staticfiles import StaticFiles
from playwright.async_api import Browser, async_playwright

from server.bench.bench_scene import scene_of
from server.bench.one_scene_server import application
from server.bench.shaped_line import ShapedLine
from server.listener.http_server import HttpServer, bind

PAGE = """<!doctype html><title>{name}</title><script type="module" src="/player/hgs-player.js"></script>
<hgs-player src="{src}" autoplay loop style="display: block; width: 480px; height: 360px"></hgs-player>"""
SOURCES = {"folder": "scene/manifest.json", "index": "/v1/scenes/bench/index.hgs", "stream": "/view/bench"}
PLAYS = "() => (document.querySelector('hgs-player')?.currentTime ?? 0) > 0.02"


async def visit(browser: Browser, port: int, mbit: float, name: str) -> tuple[float, int]:
    """Return after how many seconds the page plays, and how many bytes had come over the line."""
    async with ShapedLine(port, lambda _: mbit * 1e6) as line:
        context = await browser.new_context(viewport={"width": 480, "height": 360}, bypass_csp=True)  # an empty cache
        page = await context.new_page()
        begun = time.monotonic()
        await page.goto(f"http://{line.address}/site/{name}.html", wait_until="commit")
        while not await page.evaluate(PLAYS):
            await asyncio.sleep(0.02)
        found = time.monotonic() - begun, line.passed
        await context.close()
    return found


async def run(options: argparse.Namespace) -> None:
    """Visit both pages several times; the first visit to each warms browser and server."""
    with tempfile.TemporaryDirectory() as home:
        site = Path(home, "site")
        site.mkdir()
        (site / "scene").symlink_to(options.scene.resolve())
        for name, src in SOURCES.items():
            (site / f"{name}.html").write_text(PAGE.format(name=name, src=src))
        app = application(scene_of(options.scene), Path(home))
        routes = app.router.routes
        app.mount("/site", StaticFiles(directory=site, follow_symlink=True))
        routes.insert(0, routes.pop())  # before the pages of the server
        listener, ready = bind("127.0.0.1", 0), asyncio.Event()
        server = HttpServer(app, on_ready=ready.set)
        running = asyncio.create_task(server.serve(sockets=[listener]))
        await ready.wait()
        async with async_playwright() as playwright:
            browser = await playwright.chromium.launch(
                executable_path=shutil.which("chromium"),
                args=["--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
            )
            found: dict[str, list[tuple[float, int]]] = {name: [] for name in SOURCES}
            for turn in range(options.visits + 1):
                for name in SOURCES:
                    result = await visit(browser, listener.getsockname()[1], options.mbit, name)
                    if turn:
                        found[name].append(result)
            await browser.close()
        server.should_exit = True
        await running
    for name, visits in found.items():
        seconds = sorted(second for second, _ in visits)
        sizes = sorted(size for _, size in visits)
        print(
            f"{name}: plays after {seconds[len(seconds) // 2]:.2f} s (median), "
            f"{seconds[0]:.2f} to {seconds[-1]:.2f} s; {sizes[len(sizes) // 2] / 1e3:.0f} kB of the line"
        )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--mbit", type=float, default=2.0)
    parser.add_argument("--visits", type=int, default=8)
    asyncio.run(run(parser.parse_args()))
