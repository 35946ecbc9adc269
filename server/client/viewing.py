"""A viewer without a picture: it plays a stream as the player does, and keeps count."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from server.client.playback import Buffer, Clock
from server.client.stream_client import StreamClient, StreamRefusedError
from server.protocol.messages import Pause, Play, Seek

__all__ = ["Viewer", "Watched", "play"]

PATIENCE = 30.0  # seconds without any answer, where nobody has said for how long to watch
TICK = 0.01  # seconds between two frames of a viewer


@dataclass(frozen=True)
class Watched:
    """The figures of a viewer; times in seconds, `start` since the line was opened."""

    start: float | None  # seconds until playing began; None: not at all
    start_bytes: int  # bytes of all messages by then
    stalls: int
    waited: float  # seconds of stalls
    bytes: int
    twice: int  # bytes of chunks that came again
    shown: Sequence[tuple[float, frozenset[str]]]  # seconds of the scene, and the chunks there were; every half second
    over_http: bool = False  # no stream, but one download after the other

    def to_json(self) -> dict[str, Any]:
        """Return the plain form, without the shown moments."""
        return {name: value for name, value in vars(self).items() if name != "shown"}


class Viewer:
    """A client that plays as the player does, without a picture."""

    def __init__(self, url: str, key: str = "") -> None:
        """Watch the scene of `url`; with protocol 1 as players did that knew no layers. `key` may be asked for."""
        self.client = StreamClient(url, key=key)
        self.clock: Clock | None = None
        self.shown: list[tuple[float, frozenset[str]]] = []
        self.start_bytes = 0
        self._begun = time.monotonic()

    async def frame(self) -> None:
        """Wait for the next frame, and move the playhead."""
        await asyncio.sleep(TICK)
        manifest = self.client.manifest
        if manifest is not None and (self.clock is None or self.clock.buffer.manifest is not manifest):
            buffer = Buffer(manifest)
            if self.clock is None:
                self.clock = Clock(buffer, manifest.start)
            else:
                self.clock.buffer = buffer  # the scene has grown
        if (clock := self.clock) is None:
            return
        now = time.monotonic()
        changed = clock.tick(now, self.client.have, self.client.line.rate(now))
        if changed:
            await self.client.send(Pause(clock.time) if clock.waiting else Play(clock.time, clock.rate))
        if not clock.waiting:
            self.start_bytes = self.start_bytes or self.client.wire
            if int(2 * clock.time) != (int(2 * self.shown[-1][0]) if self.shown else None):
                self.shown.append((clock.time, frozenset(self.client.have)))

    async def sought(self, moment: float) -> float:
        """Seek, and return after how many seconds the moment can be shown."""
        begun = time.monotonic()
        if self.clock is not None:
            self.clock.seek(moment)
        await self.client.send(Seek(moment))
        if not self.can_show(moment):
            await self.client.send(Pause(moment))  # the server's playhead would run on
        while not self.can_show(moment):
            await asyncio.sleep(TICK)  # the playhead stands: a frame could take it past what was sought
        return time.monotonic() - begun

    def can_show(self, moment: float) -> bool:
        """Return whether that second of the scene can be shown."""
        return self.clock is not None and self.clock.buffer.playable(moment, self.client.have)

    @property
    def playing(self) -> bool:
        """Whether playing has begun."""
        return self.clock is not None and self.clock.started is not None

    def watched(self) -> Watched:
        """Return the figures so far."""
        clock, client = self.clock, self.client
        start = None if clock is None or clock.started is None else clock.started - self._begun
        stalls, waited = (0, 0.0) if clock is None else (clock.stalls, clock.waited)
        shown = tuple(self.shown)
        return Watched(
            start, self.start_bytes, stalls, waited, client.payload, client.twice, shown, over_http=client.over_http
        )


async def play(url: str, seconds: float | None = None, key: str = "") -> Watched:
    """Watch the scene of `url` for so many seconds, or until it has been played once.

    `url` is that of a stream, or of a folder, a manifest or an index; `key` is what the server may ask for.

    Raises:
        StreamRefusedError: the server has refused the scene, or does not answer.
    """
    viewer = Viewer(url, key=key)
    running = asyncio.create_task(viewer.client.run())
    begun, last = time.monotonic(), 0.0
    try:
        while not running.done():
            await viewer.frame()
            now = 0.0 if viewer.clock is None else viewer.clock.time
            passed = time.monotonic() - begun
            if seconds is None and passed > PATIENCE and viewer.client.manifest is None:
                raise StreamRefusedError("the server does not answer")
            if passed > seconds if seconds is not None else viewer.playing and now < last:
                break
            last = now
        else:
            await running
        return viewer.watched()
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
