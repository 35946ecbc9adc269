"""One watcher's stream as a state machine: messages in, frames out; no socket, no clock, no file.

The order of what is sent and the credits are those of docs/protocol.md, sections "Messages" and "Order".
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import assert_never

from server.client_messages import decode
from server.protocol import (
    DEFAULT_RATE,
    HEADER_BYTES,
    MAX_BALANCE,
    MAX_PAYLOAD,
    MIN_PAYLOAD,
    PROTOCOL_VERSION,
    Credit,
    End,
    Hello,
    Missing,
    Pause,
    Ping,
    Play,
    Pong,
    ProtocolError,
    Seek,
    SliceSent,
    Welcome,
    encode,
)
from server.scene_index import Chunk, SceneIndex

__all__ = ["MAX_UNSENT", "ChunkPart", "Playhead", "StreamSession"]

MAX_UNSENT = 1024  # control messages that wait for a client which asks and does not read


@dataclass(frozen=True)
class ChunkPart:
    """A chunk frame to send: `length` bytes from `offset` of the chunk."""

    chunk: Chunk
    offset: int
    length: int


@dataclass(frozen=True)
class _Pick:
    """A chunk to send, static or of the slice `index`."""

    chunk: Chunk
    index: int | None = None


@dataclass
class Playhead:
    """Where a looping player is, by dead reckoning from its last message."""

    start: float  # seconds; the scene's interval
    end: float
    time: float  # at the moment `clock`
    clock: float = 0.0  # seconds of the caller's monotonic clock
    rate: float = DEFAULT_RATE  # scene seconds per second

    def set(self, time: float, clock: float, rate: float | None = None) -> None:
        """Move to `time`, clamped to the scene."""
        self.time = min(max(time, self.start), self.end)
        self.clock = clock
        self.rate = self.rate if rate is None else rate

    def at(self, clock: float) -> float:
        """Return the scene's time at the moment `clock`, wrapped at the end as a looping player does."""
        time = self.time + self.rate * max(clock - self.clock, 0.0)
        if time <= self.end:
            return time
        duration = self.end - self.start
        return self.start + (time - self.start) % duration if duration > 0 else self.start


class StreamSession:
    """What one client still lacks, in which order it gets it, and how much it has room for.

    Feed the client's messages to `receive`, and take what is to be sent from `take` until it returns None; it may have
    more after the next message.
    """

    def __init__(self, scene: SceneIndex) -> None:
        self._scene = scene
        self._greeted = False
        self._ended = False
        self._outbox: deque[bytes] = deque()  # control messages: they need no credit
        self._balance = 0  # bytes of chunk frames that the client has room for
        self._sent_bytes = 0
        self._have: set[bytes] = set()  # chunks that are not to be sent
        self._offsets: dict[bytes, int] = {}  # of chunks that the client has in part
        self._statics = deque(scene.static)
        self._unmarked = scene.queue.copy()
        self._urgent: deque[int] = deque()  # slices alive at the time of the last seek
        self._sought = False  # after a seek statics and slices take turns
        self._static_turn = True
        self._begun: int | None = None  # the slice whose chunks are being sent
        self._current: _Pick | None = None  # the chunk whose first part has been sent
        self._playhead = Playhead(scene.start, scene.end, scene.start)

    @property
    def balance(self) -> int:
        """Bytes of chunk frames that may still be sent."""
        return self._balance

    @property
    def greeted(self) -> bool:
        """Whether the client has said hello."""
        return self._greeted

    def receive(self, data: bytes, clock: float) -> None:
        """Take a binary message of the client at the moment `clock`, in seconds of any monotonic clock.

        Raises:
            ProtocolError: close the connection with its code; the session is over.
        """
        message = decode(data)
        if isinstance(message, Hello) == self._greeted:
            raise ProtocolError(4000, "malformed", "hello comes first, and once")
        match message:
            case Hello():
                self._greet(message, clock)
            case Credit():
                self._grant(message.bytes)
            case Seek():
                self._seek(message.time, clock)
            case Play():
                self._playhead.set(message.time, clock, message.rate)
            case Pause():
                self._playhead.set(message.time, clock, 0.0)
            case Ping():
                if len(self._outbox) >= MAX_UNSENT:
                    raise ProtocolError(4000, "flood", f"{MAX_UNSENT} answers wait to be read")
                self._outbox.append(encode(Pong(message.id)))
            case _:
                assert_never(message)

    def take(self, clock: float) -> bytes | ChunkPart | None:
        """Return the next control message or chunk frame, or None when there is nothing to send or no credit for it."""
        if not self._greeted:
            return None
        pick = self._current or self._choose(clock)
        if self._outbox:
            return self._outbox.popleft()
        return None if pick is None else self._part(pick)

    def miss(self, part: ChunkPart) -> None:
        """Go on without the chunk of a frame that `take` has just returned, because it cannot be read."""
        chunk = part.chunk
        self._balance += HEADER_BYTES + part.length
        self._sent_bytes -= part.length
        self._offsets.pop(chunk.id, None)
        self._have.add(chunk.id)
        if self._current is not None and self._current.chunk == chunk:
            self._current = None
        self._outbox.append(encode(Missing(chunk.id)))

    def _greet(self, hello: Hello, clock: float) -> None:
        scene = self._scene
        sizes = scene.sizes
        self._offsets = {chunk: offset for chunk, offset in hello.parts.items() if chunk in sizes and offset > 0}
        for chunk, offset in self._offsets.items():
            if offset >= sizes[chunk]:
                detail = f"hello.parts: chunk {chunk.hex()} has {sizes[chunk]} bytes, not more than {offset}"
                raise ProtocolError(4000, "malformed", detail)
        self._greeted = True
        self._grant(hello.credits)
        self._have = {chunk for chunk in hello.have if chunk in sizes}
        for chunk in self._have:
            self._offsets.pop(chunk, None)
        self._playhead.set(scene.start if hello.time is None else hello.time, clock, hello.rate)
        kept = sum(sizes[chunk] for chunk in self._have) + sum(self._offsets.values())
        manifest = b"" if hello.manifest_id == scene.manifest_id else scene.manifest
        welcome = Welcome(
            PROTOCOL_VERSION, scene.scene_id, manifest, scene.manifest_id, remaining=scene.chunk_bytes - kept
        )
        self._outbox.append(encode(welcome))

    def _grant(self, amount: int) -> None:
        if self._balance + amount > MAX_BALANCE:
            raise ProtocolError(4009, "credit-overflow", f"the balance would rise above {MAX_BALANCE} bytes")
        self._balance += amount

    def _seek(self, time: float, clock: float) -> None:
        self._playhead.set(time, clock)
        self._sought = True
        self._static_turn = True
        self._current = self._begun = None
        self._urgent = deque(self._scene.alive(self._playhead.time))
        for index in self._urgent:
            self._unmarked.add(index)

    def _choose(self, clock: float) -> _Pick | None:
        """Return what to send next; on the way, announce the slices that are found to be complete."""
        static = self._next_static()
        if static is not None and not self._sought:
            return static
        while (index := self._next_slice(clock)) is not None:
            missing = next((chunk for chunk in self._scene.slices[index].chunks if chunk.id not in self._have), None)
            if missing is not None:
                if static is not None and self._static_turn and index not in self._urgent:
                    return static
                return _Pick(missing, index)
            self._announce(index)
        if static is None and not self._ended:
            self._ended = True
            self._outbox.append(encode(End(self._sent_bytes)))
        return static

    def _next_static(self) -> _Pick | None:
        while self._statics and self._statics[0].id in self._have:
            self._statics.popleft()
        return _Pick(self._statics[0]) if self._statics else None

    def _next_slice(self, clock: float) -> int | None:
        if self._urgent:
            return self._urgent[0]
        if self._begun is not None:
            return self._begun
        return self._unmarked.next(self._playhead.at(clock))

    def _announce(self, index: int) -> None:
        complete = self._scene.slices[index]
        self._outbox.append(encode(SliceSent(index, complete.start, complete.end)))
        self._unmarked.discard(index)
        if self._urgent and self._urgent[0] == index:
            self._urgent.popleft()
        if self._begun == index:
            self._begun = None

    def _part(self, pick: _Pick) -> ChunkPart | None:
        """Cut the next part of the chunk to the credit, and account for it."""
        chunk = pick.chunk
        offset = self._offsets.get(chunk.id, 0)
        rest = chunk.size - offset
        length = min(rest, MAX_PAYLOAD, self._balance - HEADER_BYTES)
        if length < min(rest, MIN_PAYLOAD):
            return None
        self._balance -= HEADER_BYTES + length
        self._sent_bytes += length
        self._static_turn = pick.index is not None
        if pick.index is not None:
            self._begun = pick.index
        if length < rest:
            self._offsets[chunk.id] = offset + length
            self._current = pick
        else:
            self._offsets.pop(chunk.id, None)
            self._have.add(chunk.id)
            self._current = None
        return ChunkPart(chunk, offset, length)
