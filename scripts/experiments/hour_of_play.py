"""What a browser takes in memory while a long scene plays from its beginning to its end.

    python scripts/experiments/hour_of_play.py SCENE --source stream --rate 16

SCENE is a scene folder, such as `long_scene.py` writes; the player is that which scripts/install has built. Heaps count
with their buffers, after a collection of garbage; a process counts with what it shares with no other.

Chromium is spoken to without Playwright, which has it keep up to 200 MB of what a page has fetched, for developers.
"""

from __future__ import annotations

import argparse
import asyncio
import itertools
import json
import re
import tempfile
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

from fastapi.staticfiles import StaticFiles
from websockets.asyncio.client import ClientConnection, connect

from hgs_core.bench.browser import find_chromium
from server.bench.bench_scene import scene_of
from server.bench.one_scene_server import application
from server.listener.http_server import HttpServer, bind

PAGE = """<!doctype html><title>{name}</title><link rel="icon" href="data:,">
<script type="module" src="/player/hgs-player.js"></script>
<hgs-player src="{src}" style="display: block; width: 320px; height: 240px"></hgs-player>"""
SOURCES = {"index": "/v1/scenes/bench/index.hgs", "stream": "/view/bench"}
PLAYER = "document.querySelector('hgs-player')"
SPAN = f"{PLAYER}?.player?.manifest ? [{PLAYER}.player.manifest.start, {PLAYER}.player.manifest.end] : null"
FLAGS = ("--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
MB = 1e6


class Chromium:
    """A browser, a page in it and the page's workers, by the protocol for developers."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self._numbers = itertools.count(1)
        self._answers: dict[int, asyncio.Future[dict[str, Any]]] = {}
        self._sessions: dict[str, str] = {}  # of the page and its workers, with their kinds
        self._listening = asyncio.create_task(self._listen())

    async def open(self, url: str) -> None:
        """Open the one page."""
        target = await self.ask("Target.createTarget", url="about:blank")
        page = await self.ask("Target.attachToTarget", targetId=target["targetId"], flatten=True)
        self._page = page["sessionId"]
        self._sessions[self._page] = "page"
        await self.ask("Target.setAutoAttach", self._page, autoAttach=True, waitForDebuggerOnStart=False, flatten=True)
        await self.ask("Page.setBypassCSP", self._page, enabled=True)  # the server's own pages have other policies
        await self.ask("Page.navigate", self._page, url=url)

    async def evaluate(self, expression: str) -> Any:
        """Return what an expression gives in the page."""
        found = await self.ask("Runtime.evaluate", self._page, expression=expression, returnByValue=True)
        return found["result"].get("value")

    async def heaps(self) -> tuple[float, float]:
        """Return the bytes of the page's heap and of its workers', with their buffers, after a collection."""
        sums = {"page": 0.0, "worker": 0.0}
        for session, kind in self._sessions.items():
            await self.ask("HeapProfiler.collectGarbage", session)
            usage = await self.ask("Runtime.getHeapUsage", session)
            sums[kind] += usage["usedSize"] + usage["backingStorageSize"]
        return sums["page"], sums["worker"]

    async def processes(self) -> tuple[float, float]:
        """Return the bytes of the page's process and of the one that draws."""
        found = await self.ask("SystemInfo.getProcessInfo")
        most = {"renderer": 0.0, "GPU": 0.0}
        for process in found["processInfo"]:
            if process["type"] in most:
                most[process["type"]] = max(most[process["type"]], _resident(process["id"]))
        return most["renderer"], most["GPU"]

    async def ask(self, method: str, session: str = "", **parameters: Any) -> dict[str, Any]:
        """Return the answer to a request."""
        number = next(self._numbers)
        answer = self._answers[number] = asyncio.get_running_loop().create_future()
        message = {"id": number, "method": method, "params": parameters}
        await self._socket.send(json.dumps(message | ({"sessionId": session} if session else {})))
        return await answer

    async def _listen(self) -> None:
        async for text in self._socket:
            message = json.loads(text)
            if "id" in message:
                answer = self._answers.pop(message["id"])
                if "error" in message:
                    answer.set_exception(RuntimeError(message["error"]["message"]))
                else:
                    answer.set_result(message["result"])
            elif message["method"] == "Target.attachedToTarget":
                kind = message["params"]["targetInfo"]["type"]
                if kind == "worker":
                    self._sessions[message["params"]["sessionId"]] = kind


def _resident(pid: int) -> float:
    status = Path(f"/proc/{pid}/status").read_text()
    match = re.search(r"RssAnon:\s+(\d+) kB", status)
    return 1024.0 * int(match[1]) if match else 0.0


@asynccontextmanager
async def started_chromium(folder: Path) -> AsyncIterator[Chromium]:
    """Start the system's Chromium without a window."""
    program = find_chromium()
    assert program is not None
    process = await asyncio.create_subprocess_exec(
        program,
        *FLAGS,
        "--remote-debugging-port=0",
        f"--user-data-dir={folder}",
        "about:blank",
        stdout=asyncio.subprocess.DEVNULL,
        stderr=asyncio.subprocess.PIPE,
    )
    assert process.stderr is not None
    address = None
    while address is None:
        line = (await process.stderr.readline()).decode()
        assert line, "Chromium has ended"
        address = re.search(r"ws://\S+", line)
    draining = asyncio.create_task(process.stderr.read())
    async with connect(address[0], max_size=None) as socket:
        browser = Chromium(socket)
        yield browser
        await browser.ask("Browser.close")
    await process.wait()
    await draining


@asynccontextmanager
async def served(options: argparse.Namespace, home: Path) -> AsyncIterator[str]:
    """Serve the scene, and a page with the player on it; yield the page's address."""
    site = home / "site"
    site.mkdir()
    (site / "page.html").write_text(PAGE.format(name=options.source, src=SOURCES[options.source]))
    app = application(scene_of(options.scene), home)
    routes = app.router.routes
    app.mount("/site", StaticFiles(directory=site))
    routes.insert(0, routes.pop())  # before the pages of the server
    listener, ready = bind("127.0.0.1", 0), asyncio.Event()
    server = HttpServer(app, on_ready=ready.set)
    running = asyncio.create_task(server.serve(sockets=[listener]))
    await ready.wait()
    yield f"http://127.0.0.1:{listener.getsockname()[1]}/site/page.html"
    server.should_exit = True
    await running


async def play(browser: Chromium, address: str, options: argparse.Namespace) -> None:
    """Play the scene, and print a line for every look."""
    await browser.open(address)
    while (span := await browser.evaluate(SPAN)) is None:
        await asyncio.sleep(0.1)
    start, end = span
    loop = str(options.passes > 1).lower()
    await browser.evaluate(f"{PLAYER}.playbackRate = {options.rate}; {PLAYER}.loop = {loop}; {PLAYER}.play()")
    begun, due, passed, last = time.monotonic(), 0.0, 0, start
    print("scene, s | clock, s | heap of the page, MB | of its worker, MB | process of both, MB | of what draws, MB")
    while True:
        now = await browser.evaluate(f"{PLAYER}.currentTime")
        passed, last = passed + (now < last), now
        at = passed * (end - start) + now - start
        over = at >= options.passes * (end - start) - 0.1
        if at >= due or over:
            figures = " | ".join(f"{size / MB:.0f}" for size in (*await browser.heaps(), *await browser.processes()))
            print(f"{at:.0f} | {time.monotonic() - begun:.0f} | {figures}", flush=True)
            due = at + options.every
        if over:
            return
        await asyncio.sleep(0.5)


async def run(options: argparse.Namespace) -> None:
    """Serve the scene and play it."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        home, profile = Path(folder, "home"), Path(folder, "profile")
        home.mkdir()
        async with served(options, home) as address, started_chromium(profile) as browser:
            await play(browser, address, options)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--source", choices=tuple(SOURCES), default="stream")
    parser.add_argument("--rate", type=float, default=16.0)
    parser.add_argument("--passes", type=int, default=1, help="how often to play the scene, one pass after the other")
    parser.add_argument("--every", type=float, default=600.0, help="seconds of the scene between two looks")
    asyncio.run(run(parser.parse_args()))
