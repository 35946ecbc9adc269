"""Send the server requests and control frames at random, and see that none is its fault.

    .venv/bin/python scripts/fuzz_server.py --requests 10000 --frames 100000 --seed 1

Requests follow the OpenAPI description of the server, some of their parts replaced by what breaks programs; frames are
those of a client of the stream, mutated, on streams of a made-up scene. A request must be answered below 500, a stream
ended by nothing but a close of docs/stream.md, nothing logged as an error, and no task and no stream may be left.
What is not so is printed, and the exit status is 1. Both go through the whole application, without sockets.
"""

from __future__ import annotations

import argparse
import asyncio
import logging
import random
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, MutableMapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from fastapi import FastAPI

from jobs.home.home import Home
from scripts.fuzz_inputs import packed, random_frame, random_requests
from server.app import create_app
from server.bench.bench_scene import made_up_scene
from server.bench.one_scene_server import application
from server.captures.capture_folders import CaptureFolders

CLOSES = {1003, 1009, 4000, 4001, 4004, 4008, 4009}  # closes that a client's message may cause
LONGEST = 30.0  # seconds that a stream may take to end
HANGS = -1  # no close at all
FRAMES = 60  # frames of one stream; more than 200 at once would wait


class Faults(logging.Handler):
    """A handler that keeps the errors in the server's log."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.seen: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        """Keep the message."""
        self.seen.append(record.getMessage())


def main(arguments: Sequence[str] | None = None) -> int:
    """Fuzz, and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--requests", type=int, default=10_000)
    parser.add_argument("--frames", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    faults = Faults()
    logging.getLogger().addHandler(faults)
    try:
        with tempfile.TemporaryDirectory() as folder:
            problems = asyncio.run(_fuzz(Path(folder).resolve(), options.requests, options.frames, options.seed))
    finally:
        logging.getLogger().removeHandler(faults)
    problems += [f"logged: {line}" for line in faults.seen]
    for problem in problems[:20]:
        print(problem)
    print(f"{len(problems)} faults")
    return 1 if problems else 0


async def _fuzz(folder: Path, requests: int, frames: int, seed: int) -> list[str]:
    problems: list[str] = []
    scene = made_up_scene(4, static_bytes=120_000, slice_bytes=9_000)
    app, published = (
        create_app(Home.at(folder / "home"), captures=CaptureFolders((folder,))),
        application(scene, folder),
    )
    begun, answers = time.monotonic(), Counter[int]()
    try:
        known = {
            "upload_id": ["x"],
            "job_id": ["x"],
            "scene_id": ["bench"],
            "chunk_id": [*scene.chunks],
            "number": ["0"],
        }
        cases = random_requests(app, known, random.Random(seed))
        for _ in range(requests):
            method, target, headers, body = next(cases)
            of_scene = method in ("GET", "HEAD") and re.match("/v1/(scenes/|chunks/)", target)
            status, made = await _ask(published if of_scene else app, method, target, headers, body)
            if made.startswith("/v1/uploads/") and status == 201:
                known["upload_id"].append(made.split("/")[3])
            answers[status] += 1
            if not 200 <= status < 500:
                problems.append(f"{status}: {method} {target[:200]} {headers} {body[:200]!r}")
    finally:
        app.state.service.uploads.close()
        published.state.service.uploads.close()
        app.state.service.jobs.close()
    _say("requests", requests, begun, answers)

    begun, closes, read = time.monotonic(), Counter[int](), 0
    app = published
    before = len(asyncio.all_tasks())
    dice = random.Random(seed)
    while read < frames:
        messages = [random_frame(dice) for _ in range(min(FRAMES, frames - read))]
        if dice.random() < 0.9:
            messages[0] = packed({"type": "hello", "protocol": 1, "credits": dice.choice([0, 4144, 1 << 20])})
        count, close = await _stream(app, messages)
        if close == HANGS:
            problems.append(f"a stream does not end: {messages[:count]!r:.2000}")
            break
        read += count
        closes[close] += 1
        if close not in CLOSES | {0}:
            problems.append(f"closed with {close}: {messages[:count]!r:.400}")
    await asyncio.sleep(0.1)
    if left := len(asyncio.all_tasks()) - before:
        problems.append(f"{left} tasks are left")
    if left := len(app.state.service.streams):
        problems.append(f"{left} streams are left")
    _say("frames", read, begun, closes)
    return problems


def _say(what: str, count: int, begun: float, found: Mapping[int, int]) -> None:
    ends = ", ".join(f"{number} x {code or 'left'}" for code, number in sorted(found.items()))
    print(f"{count} {what} in {time.monotonic() - begun:.0f} s: {ends}", flush=True)


async def _ask(
    app: FastAPI, method: str, target: str, headers: Sequence[tuple[str, str]], body: bytes
) -> tuple[int, str]:
    """Return the status of the answer, and its Location."""
    path, _, query = target.partition("?")
    named = {name for name, _ in headers}
    fields = headers if "Host" in named else [("Host", "localhost"), *headers]
    scope = {
        "type": "http",
        "asgi": {"version": "3.0", "spec_version": "2.3"},
        "http_version": "1.1",
        "scheme": "http",
        "server": ("127.0.0.1", 80),
        "client": ("127.0.0.1", 1234),
        "method": method,
        "root_path": "",
        "state": {},
        "path": unquote(path, errors="replace"),
        "raw_path": path.encode(),
        "query_string": query.encode(),
        "headers": [(name.lower().encode(), value.encode("latin-1")) for name, value in fields],
    }
    messages = [{"type": "http.request", "body": body, "more_body": False}]
    status, made = 0, ""

    async def receive() -> dict[str, Any]:
        return messages.pop() if messages else {"type": "http.disconnect"}

    async def send(message: MutableMapping[str, Any]) -> None:
        nonlocal status, made
        status = message.get("status", status)
        made = dict(message.get("headers", ())).get(b"location", made.encode()).decode("latin-1")

    await app(scope, receive, send)
    return status, made


async def _stream(app: FastAPI, messages: Sequence[bytes]) -> tuple[int, int]:
    """Send the messages to the scene's stream; return how many were read, and the code it was closed with, or 0."""
    closed, sent = 0, 0
    waiting = [{"type": "websocket.connect"}, *({"type": "websocket.receive", "bytes": data} for data in messages)]
    waiting.reverse()
    scope = {
        "type": "websocket",
        "asgi": {"version": "3.0", "spec_version": "2.3"},
        "http_version": "1.1",
        "scheme": "ws",
        "server": ("127.0.0.1", 80),
        "client": ("127.0.0.1", 1234),
        "root_path": "",
        "state": {},
        "subprotocols": [],
        "path": "/v1/scenes/bench/stream",
        "raw_path": b"/v1/scenes/bench/stream",
        "query_string": b"",
        "headers": [(b"host", b"localhost")],
    }

    async def receive() -> dict[str, Any]:
        nonlocal sent
        await asyncio.sleep(0)
        if not waiting:
            return {"type": "websocket.disconnect", "code": 1006}
        message = waiting.pop()
        sent += "bytes" in message
        return message

    async def send(message: MutableMapping[str, Any]) -> None:
        nonlocal closed
        await asyncio.sleep(0)
        if message["type"] == "websocket.close":
            closed = message.get("code", 1000)

    try:
        async with asyncio.timeout(LONGEST):
            await app(scope, receive, send)
    except TimeoutError:
        closed = HANGS
    return sent, closed


if __name__ == "__main__":
    sys.exit(main())
