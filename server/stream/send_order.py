"""Sending order of chunks: base layers of the visible slices first, then their refinements.

The order is that of docs/stream.md, section "Order".
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from server.protocol.messages import MAX_PAYLOAD
from server.scenes.scene_index import Chunk, SceneIndex, Slice
from server.scenes.slice_queue import SliceQueue

__all__ = ["COMPLETE", "Mark", "SendOrder"]

PAGES_SENT_AHEAD = 12.0  # playing time for which pages of the manifest are sent before the chunks they list
SENT_AHEAD = (3.0, 8.0, math.inf)  # playing times for which base layers and then refinements are sent, in turn
COMPLETE = 1  # layer of a mark: 1 means all layers, 0 the base


@dataclass(frozen=True)
class Mark:
    """A client has all chunks of the slice `index`, or for layer 0 those of its base."""

    index: int
    layer: int


class SendOrder:
    """Chunks of a scene missing at one client. `marks` collects the slices that become complete."""

    def __init__(self, scene: SceneIndex, have: Collection[bytes] = ()) -> None:
        """Leave out the chunks that the client has from the start."""
        self.marks: deque[Mark] = deque()
        self._scene = scene
        self._have = set(have)
        self._left_out: frozenset[bytes] = frozenset()
        self._room = deque(chunk for chunk in scene.static if chunk.layer == 0)
        self._details = deque(chunk for chunk in scene.static if chunk.layer > 0)
        self._room_bytes = sum(chunk.size for chunk in self._room)
        self._bases = scene.queue.copy()  # slices without a mark
        self._slices = scene.queue.copy()
        self._static_turn = True  # refinements of statics and of slices take turns
        self._sought = False
        self._pages = _queue(scene.pages)
        self._sounds: SliceQueue | None = None  # pieces possibly missing; None: no sound wanted

    @property
    def left_out(self) -> int:
        """Size of the refinements beyond the client's limit, bytes."""
        return sum(self._scene.sizes[chunk] for chunk in self._left_out - self._have)

    def limit(self, splats: int | None) -> None:
        """Leave out refinements that would exceed `splats` per picture; None: no limit."""
        self._left_out = frozenset() if splats is None else _beyond(self._scene, splats)
        self._details = deque(chunk for chunk in self._scene.static if chunk.layer > 0)
        self._slices = self._scene.queue.copy()

    def hear(self, wanted: bool) -> None:
        """Start or stop sending the scene's sound."""
        self._sounds = _queue(self._scene.sounds) if wanted else None

    def grow(self, scene: SceneIndex, splats: int | None) -> None:
        """Add the new parts of the scene; `splats` is the limit."""
        ends = [piece.end for piece in scene.slices]
        self._scene = scene
        self._bases, self._slices = self._bases.grown(ends), self._slices.grown(ends)
        if splats is not None:
            self.limit(splats)
        self._pages = _queue(scene.pages)
        self.hear(self._sounds is not None)

    def has(self, chunk: Chunk) -> bool:
        """Return whether the chunk need not be sent."""
        return chunk.id in self._have or chunk.id in self._left_out

    def settle(self, chunk: Chunk) -> None:
        """Record that the client has the chunk, or cannot get it."""
        self._have.add(chunk.id)

    def sought(self, time: float) -> None:
        """Mark the slices alive at `time` again, after a seek."""
        self._static_turn = self._sought = True
        for index in self._scene.alive(time):
            self._bases.add(index)
            self._slices.add(index)

    def next(self, time: float, rate: float, measured: float | None = None) -> Chunk | None:
        """Return the next chunk to send, or None if nothing is missing; add marks for slices found complete.

        The playhead is at `time` and moves at `rate` scene seconds per second; the line carries `measured` bytes/s.
        """
        speed = rate or 1.0  # a stopped playhead will move again
        # A slice's refinements should arrive before the slice is over.
        late = 0.0 if measured is None else rate * MAX_PAYLOAD / max(measured, 1.0)
        base = self._next_base(time)
        room = self._first(self._room)
        if room is not None:
            if base is not None and base[0] <= 0 and (self._sought or self._is_behind(base[2])):
                return base[1]
            return room
        if base is not None and base[0] <= 0:
            return base[1]
        page = self._next_piece(self._scene.pages, self._pages, time)
        if page is not None and page[0] <= PAGES_SENT_AHEAD * speed:
            return page[1]
        sound = self._next_piece(self._scene.sounds, self._sounds, time)
        if sound is not None and page is not None and sound[0] >= page[0]:
            sound = None  # the client needs the page first, which lists it
        for ahead in SENT_AHEAD:
            if base is not None and base[0] <= ahead * speed:
                return base[1]
            if sound is not None and sound[0] <= ahead * speed:
                return sound[1]
            still, moving = self._first(self._details), self._refinement(time, time + late, ahead * speed)
            if still is not None and (moving is None or self._static_turn):
                self._static_turn = moving is None
                return still
            if moving is not None:
                self._static_turn = True
                return moving
        return None if page is None else page[1]

    def _first(self, chunks: deque[Chunk]) -> Chunk | None:
        while chunks and self.has(chunks[0]):
            chunks.popleft()
        return chunks[0] if chunks else None

    def _next_base(self, time: float) -> tuple[float, Chunk, int] | None:
        """Return the distance in scene seconds to the next slice with an incomplete base, a missing chunk, and its
        index.
        """
        while (index := self._bases.next(time)) is not None:
            for chunk in self._scene.slices[index].base:
                if not self.has(chunk):
                    return self._distance(self._scene.slices, self._bases, index, time), chunk, index
            self._bases.discard(index)
            self.marks.append(Mark(index, 0))
        return None

    def _next_piece(self, pieces: Sequence[Slice], queue: SliceQueue | None, time: float) -> tuple[float, Chunk] | None:
        """Return the distance in scene seconds to the next missing page or piece of sound, and its chunk."""
        while queue is not None and (index := queue.next(time)) is not None:
            chunk = pieces[index].chunks[0]
            if not self.has(chunk):
                return self._distance(pieces, queue, index, time), chunk
            queue.discard(index)
        return None

    def _is_behind(self, index: int) -> bool:
        """Return whether less of a slice's base has been sent than of the static base."""
        base = self._scene.slices[index].base
        sent = sum(chunk.size for chunk in base if chunk.id in self._have)
        room = self._room_bytes - sum(chunk.size for chunk in self._room)
        return sent * self._room_bytes < room * sum(chunk.size for chunk in base)

    def _refinement(self, time: float, begin: float, ahead: float) -> Chunk | None:
        """Return the lowest missing layer within `ahead` scene seconds, of the first slice that lacks it."""
        if math.isinf(ahead):
            index = self._slices.next(begin)
            while index is not None and (chunk := self._missing(index)) is None:
                index = self._slices.next(begin)
            return None if index is None else self._missing(index)
        best: Chunk | None = None
        for index in self._within(time, begin, ahead):
            chunk = self._missing(index)
            if chunk is not None and (best is None or chunk.layer < best.layer):
                best = chunk
        return best

    def _missing(self, index: int) -> Chunk | None:
        """Return the first missing refinement of a slice; mark the slice if there is none."""
        for chunk in self._scene.slices[index].refinements:
            if not self.has(chunk):
                return chunk
        if all(map(self.has, self._scene.slices[index].base)):
            self._slices.discard(index)
            self.marks.append(Mark(index, COMPLETE))
        return None

    def _within(self, time: float, begin: float, ahead: float) -> list[int]:
        """Return the slices shown between `begin` and `ahead` seconds after `time`, wrapped around the scene's end."""
        found: list[int] = []
        for moment, limit in ((begin, time + ahead), (-math.inf, time + ahead - self._duration)):
            index = self._slices.first_shown_after(moment)
            while index is not None and self._scene.slices[index].start <= limit and index not in found:
                found.append(index)
                index = self._slices.first_shown_after(moment, index + 1)
        return found

    def _distance(self, pieces: Sequence[Slice], queue: SliceQueue, index: int, time: float) -> float:
        over = queue.first_shown_after(time, index) != index
        return pieces[index].start - time + (self._duration if over else 0.0)

    @property
    def _duration(self) -> float:
        return self._scene.end - self._scene.start


def _queue(pieces: Sequence[Slice]) -> SliceQueue:
    return SliceQueue([piece.end for piece in pieces])


def _beyond(scene: SceneIndex, splats: int) -> frozenset[bytes]:
    """Return the refinements beyond a budget of `splats` per picture; bases are always kept."""
    moving = max((sum(chunk.splats for chunk in piece.chunks) for piece in scene.slices), default=0)
    left_out = _over(scene.static, max(splats // 2, splats - moving))
    room = splats - sum(chunk.splats for chunk in scene.static if chunk.id not in left_out)
    for piece in scene.slices:
        left_out |= _over(sorted(piece.chunks, key=lambda chunk: chunk.layer), room)
    return frozenset(left_out)


def _over(chunks: Collection[Chunk], room: int) -> set[bytes]:
    left_out: set[bytes] = set()
    for chunk in chunks:
        room -= chunk.splats
        if room < 0 and chunk.layer > 0:
            left_out.add(chunk.id)
    return left_out
