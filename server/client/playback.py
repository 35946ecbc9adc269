"""Playback of an arriving scene: playable moments, pauses, and the rate of the line.

Nothing here draws, and nothing asks for the time. The rules are those of docs/stream.md, "Waiting for data".
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Collection
from dataclasses import dataclass

from hgs_core.codec.format.layers import SLICE_PART, STATIC_PART, layers
from hgs_core.codec.format.manifest import Manifest

__all__ = ["Buffer", "Clock", "Throughput"]

FIRST = 1.5  # seconds of playing before a playhead waits again that begins somewhere
AGAIN = 3.0  # and of one that has waited there
FORESEEN = 10.0  # seconds of playing
SAMPLE = 0.1  # seconds, at least
IDLE = 2.0  # seconds without anything, of which nothing is learnt
HALVES = (0.5, 3.0)  # seconds in which what was measured loses half its weight


class Throughput:
    """Bytes per second of a line: the lower of a fast mean and a slow one."""

    def __init__(self) -> None:
        self._means = [(0.0, 0.0) for _ in HALVES]  # weighted sum, and weight
        self._since: float | None = None
        self._bytes = 0

    def count(self, size: int, now: float) -> None:
        """Note bytes that have come at `now`, in seconds of any monotonic clock."""
        passed = IDLE if self._since is None else now - self._since
        self._bytes += size
        if passed < SAMPLE:
            return
        if passed < IDLE:
            for place, (half, (total, weight)) in enumerate(zip(HALVES, self._means, strict=True)):
                kept = 0.5 ** (passed / half)
                self._means[place] = (kept * total + (1 - kept) * self._bytes / passed, kept * weight + 1 - kept)
        self._since, self._bytes = now, 0

    def rate(self, now: float) -> float:
        """Return bytes per second; 0 while nothing is known, or nothing has come for long."""
        if self._since is None or now - self._since > IDLE:
            return 0.0
        return min(total / weight if weight else 0.0 for total, weight in self._means)


class Buffer:
    """Which moments of a scene can be shown with the chunks that are there."""

    def __init__(self, manifest: Manifest) -> None:
        """Ask for the base layers of everything shown."""
        self.manifest = manifest
        self._starts = [piece.start for piece in manifest.slices]
        self._bytes: dict[str, int] = {}
        base: set[str] = set()
        moving = ((piece.chunks, SLICE_PART) for piece in manifest.slices)
        for entries, part in ((manifest.static, STATIC_PART), *moving):
            for entry, layer in zip(entries, layers([entry.bytes for entry in entries], part), strict=True):
                self._bytes[entry.id] = entry.bytes
                if layer == 0:
                    base.add(entry.id)
        self._room = [entry.id for entry in manifest.static if entry.id in base]
        self._slices = [
            [name for name in (*piece.needs, *(entry.id for entry in piece.chunks)) if name in base]
            for piece in manifest.slices
        ]

    def slice_at(self, time: float) -> int:
        """Return the index of the slice that is shown at `time`, in seconds."""
        return max(0, bisect_right(self._starts, time) - 1)

    def playable(self, time: float, have: Collection[str]) -> bool:
        """Return whether the chunks required at `time` are there."""
        return all(name in have for name in (*self._room, *self._slices[self.slice_at(time)]))

    def lasts(self, time: float, rate: float, have: Collection[str], line: float, reserve: float) -> bool:
        """Return whether playing from `time` will not wait, or not within `reserve` seconds.

        The line brings `line` bytes per second; `rate` is in seconds of the scene per second.
        """
        lacking: set[str] = set()
        for index in range(self.slice_at(time), len(self._slices)):
            wait = (self._starts[index] - time) / rate
            if wait > FORESEEN:
                break
            lacking.update(name for name in self._slices[index] if name not in have)
            if sum(self._bytes[name] for name in lacking) > line * max(0.0, wait):
                return wait >= reserve
        return True


@dataclass
class Clock:
    """A playhead that enters no moment that cannot be shown. It loops, or waits at the edge of a scene that grows."""

    buffer: Buffer
    time: float  # seconds of the scene
    rate: float = 1.0
    stalls: int = 0  # stalls after the first movement
    waited: float = 0.0  # seconds, since it first moved
    started: float | None = None  # moment of the first movement
    waiting: bool = True
    at_edge: bool = False  # it waits for the scene to grow, which is no stall
    _reserve: float = FIRST
    _last: float | None = None

    def seek(self, time: float) -> None:
        """Go somewhere else; waiting there for data is no stall."""
        self.time = time
        self.waiting, self._reserve = True, FIRST

    def tick(self, now: float, have: Collection[str], line: float) -> bool:
        """Move on to `now`, in seconds of any monotonic clock; return whether the playhead begins or ceases to wait."""
        passed = 0.0 if self._last is None else now - self._last
        self._last = now
        manifest = self.buffer.manifest
        next_time = self.time + min(0.25, passed) * self.rate
        ends = next_time >= manifest.end
        if ends:
            next_time = manifest.start if manifest.live is None else manifest.end
        moves = self.buffer.playable(next_time, have)
        self.at_edge = ends and moves and manifest.live is not None
        if self.at_edge:
            self.time, moves = next_time, False
        if moves and self.waiting:
            moves = self.buffer.lasts(next_time, self.rate, have, line, self._reserve)
        before, self.waiting = self.waiting, not moves
        if moves:
            self.time, self._reserve = next_time, AGAIN
            self.started = now if self.started is None else self.started
        elif self.started is not None and not self.at_edge:
            self.waited += passed
            self.stalls += not before
        return before != self.waiting
