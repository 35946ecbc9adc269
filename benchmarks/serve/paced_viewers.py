"""Viewers that take a scene as fast as it plays and look at nothing of it: one process has room for hundreds."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import multiprocessing
import random
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection

import msgpack
import websockets
from websockets.asyncio.client import ClientConnection

from server.listener.connection_limits import raise_open_file_limit
from server.protocol.messages import CHUNK_FRAME, MIN_PAYLOAD, PROTOCOL_VERSION, Credit, Hello, encode

__all__ = ["Crowd", "CrowdFigures", "Pace"]

STEP = 0.5  # seconds between two grants
TOGETHER = 500  # viewers of one process
JOIN_RATE = 50.0  # viewers that join in a second


@dataclass(frozen=True)
class Pace:
    """The pace of a viewer: statics and two seconds of the rest at once, and then as it plays."""

    first: int  # bytes
    rate: float  # bytes per second
    stay: float  # seconds, at least, from coming to leaving


@dataclass
class CrowdFigures:
    """The figures of viewers since the last look."""

    bytes: int = 0
    visits: int = 0  # scenes that were begun
    lost: int = 0  # connections that broke or were refused
    lateness: list[float] = field(default_factory=list)  # seconds from each grant to its last byte
    processor: float = 0.0  # seconds that their processes took

    def add(self, other: CrowdFigures) -> None:
        """Add those of other viewers."""
        self.bytes += other.bytes
        self.visits += other.visits
        self.lost += other.lost
        self.lateness += other.lateness
        self.processor += other.processor


class Crowd:
    """Viewers in processes of their own; each watches a scene to its end and then begins anew, with nothing."""

    def __init__(self, urls: Sequence[str], viewers: int, pace: Pace) -> None:
        """Let `viewers` watch the streams of `urls`, in turn; they join one after another within `joining` seconds."""
        self.joining = viewers / JOIN_RATE
        spawn = multiprocessing.get_context("spawn")
        self._pipes: list[Connection] = []
        self._processes = []
        parts = -(-viewers // TOGETHER)
        for part in range(parts):
            ours, theirs = spawn.Pipe()
            mine = range(part, viewers, parts)
            arguments = (theirs, [urls[viewer % len(urls)] for viewer in mine], pace, self.joining)
            process = spawn.Process(target=_watch, args=arguments, daemon=True)
            process.start()
            theirs.close()  # else its end would not be noticed
            self._pipes.append(ours)
            self._processes.append(process)

    async def figures(self) -> CrowdFigures:
        """Return the figures since the last look."""
        total = CrowdFigures()
        for pipe in self._pipes:
            pipe.send("figures")
        for pipe in self._pipes:
            total.add(await asyncio.to_thread(pipe.recv))
        return total

    def close(self) -> None:
        """Let all viewers leave."""
        for pipe in self._pipes:
            pipe.close()
        for process in self._processes:
            process.join(10)
            process.kill()


def _watch(pipe: Connection, urls: Sequence[str], pace: Pace, joining: float) -> None:
    raise_open_file_limit()
    gc.disable()  # measurements do not wait for it; a viewer leaves no more behind than there is room for
    with contextlib.suppress(EOFError, OSError):
        asyncio.run(_serve_figures(pipe, urls, pace, joining))


async def _serve_figures(pipe: Connection, urls: Sequence[str], pace: Pace, joining: float) -> None:
    viewers = [_PacedViewer(url, pace) for url in urls]
    running = [asyncio.create_task(viewer.run(joining * random.random())) for viewer in viewers]
    told = 0.0  # seconds of processor time
    try:
        while await asyncio.to_thread(pipe.recv):
            total = CrowdFigures()
            for viewer in viewers:
                total.add(viewer.figures)
                viewer.figures = CrowdFigures()
            total.processor = time.process_time() - told
            told += total.processor
            pipe.send(total)
    finally:
        for task in running:
            task.cancel()
        await asyncio.gather(*running, return_exceptions=True)


class _PacedViewer:
    def __init__(self, url: str, pace: Pace) -> None:
        self.figures = CrowdFigures()
        self._url, self._pace = url, pace
        self._came = 0  # bytes of chunk frames of this visit
        self._ended = False
        self._grants: list[tuple[int, float]] = []  # bytes that are granted in all with this one, and when

    async def run(self, delay: float) -> None:
        await asyncio.sleep(delay)
        while True:
            try:
                async with websockets.connect(
                    self._url, compression=None, max_size=None, ping_interval=None, open_timeout=60, close_timeout=1
                ) as socket:
                    await self._visit(socket)
            except (OSError, TimeoutError, websockets.WebSocketException):
                self.figures.lost += 1
                await asyncio.sleep(1 + random.random())

    async def _visit(self, socket: ClientConnection) -> None:
        self._came, self._ended, self._grants = 0, False, []
        self.figures.visits += 1
        begun = time.monotonic()
        granted = self._pace.first
        await socket.send(encode(Hello(PROTOCOL_VERSION, granted, follow=True)))
        listening = asyncio.create_task(self._listen(socket))
        try:
            step = 0
            while not self._ended or time.monotonic() < begun + self._pace.stay:
                step += 1
                await asyncio.wait({listening}, timeout=max(0.0, begun + step * STEP - time.monotonic()))
                if listening.done():
                    listening.result()
                    return
                if self._ended:
                    continue
                amount = int(self._pace.rate * STEP)
                granted += amount
                self._grants.append((granted, time.monotonic()))
                await socket.send(encode(Credit(amount)))
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)
            socket.transport.abort()  # a farewell would cost a round trip

    async def _listen(self, socket: ClientConnection) -> None:
        async for message in socket:
            if message[0] == CHUNK_FRAME:
                self._came += len(message)
                self.figures.bytes += len(message)
                # The server may leave as much of a grant as makes no frame.
                while self._grants and self._came > self._grants[0][0] - 2 * MIN_PAYLOAD:
                    self.figures.lateness.append(time.monotonic() - self._grants.pop(0)[1])
            elif msgpack.unpackb(message if isinstance(message, bytes) else message.encode())["type"] == "end":
                self._ended = True
