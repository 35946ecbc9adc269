"""One client's stream as a state machine: messages in, frames out; no socket, no clock, no file.

Sending order and credits follow docs/stream.md, "Messages of the client" and "Order".
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import assert_never

from server.protocol.client_messages import decode
from server.protocol.messages import (
    PROTOCOL_VERSION,
    Credit,
    End,
    Grow,
    Hello,
    Limits,
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
from server.protocol.stream_endings import Closing
from server.scenes.scene_growth import is_later
from server.scenes.scene_index import Chunk, SceneIndex
from server.stream.client_cache import ClientCache
from server.stream.flow_control import FlowControl
from server.stream.playhead import Playhead
from server.stream.send_order import Mark, SendOrder

__all__ = ["MAX_UNSENT", "ChunkPart", "StreamSession"]

MAX_UNSENT = 1024  # unread control messages per client


@dataclass(frozen=True)
class ChunkPart:
    """A chunk frame to send: `length` bytes from `offset` of the chunk."""

    chunk: Chunk
    offset: int
    length: int
    data: bytes | None = None  # the whole page, for pages of the manifest; chunks are in the store


class StreamSession:
    """State of one client's stream: missing chunks, sending order and credit.

    Pass the client's messages to `receive`, and send the results of `take` until it returns None; it may have
    more after the next message.
    """

    def __init__(self, scene: SceneIndex) -> None:
        self._scene = scene
        self.waits = 0  # pauses of a client to which data was on its way: the viewer says so when it has to wait
        self._greeted = False
        self._ended = False
        self._outbox: deque[bytes] = deque()  # control messages: they need no credit
        self._flow = FlowControl()
        self._limits = Limits()
        self._offsets: dict[bytes, int] = {}  # bytes sent or cached of incomplete chunks
        self._order = SendOrder(scene)
        self._current: Chunk | None = None  # the chunk whose first part has been sent
        self._playhead = Playhead(scene.start, scene.end, scene.start, grows=scene.live is not None)
        self._follows = False

    @property
    def scene(self) -> SceneIndex:
        """The scene, as far as it has grown."""
        return self._scene

    @property
    def balance(self) -> int:
        """Bytes of chunk frames that may still be sent."""
        return self._flow.balance

    @property
    def greeted(self) -> bool:
        """Whether the client has sent its hello."""
        return self._greeted

    def receive(self, data: bytes, clock: float) -> None:
        """Process a binary message of the client at the moment `clock`, in seconds of any monotonic clock.

        Raises:
            ProtocolError: close the connection with its code; the session is over.
        """
        message = decode(data)
        if isinstance(message, Hello) == self._greeted:
            raise ProtocolError(Closing.MALFORMED, "hello must be the first message, and sent once")
        match message:
            case Hello():
                self._greet(message, clock)
            case Credit():
                self._flow.grant(message.bytes)
            case Seek():
                self._seek(message.time, clock)
            case Play():
                self._playhead.set(message.time, clock, message.rate)
            case Pause():
                self.waits += not self._ended and self._playhead.rate > 0
                self._playhead.set(message.time, clock, 0.0)
            case Limits():
                self._limit(message)
            case Ping():
                if len(self._outbox) >= MAX_UNSENT:
                    raise ProtocolError(Closing.FLOOD, f"{MAX_UNSENT} responses are waiting to be read")
                self._outbox.append(encode(Pong(message.id)))
            case _:
                assert_never(message)

    def take(self, clock: float) -> bytes | ChunkPart | None:
        """Return the next control message or chunk frame, or None if there is nothing to send or no credit for it."""
        if not self._greeted:
            return None
        chunk = self._current or self._choose(clock)
        if self._outbox:
            return self._outbox.popleft()
        return None if chunk is None or self.wait(clock) is not None else self._part(chunk, clock)

    def grow(self, scene: SceneIndex, clock: float) -> None:
        """Continue with a later version of the scene at the moment `clock`, unless the client does not follow it.

        Raises:
            ProtocolError: it is another scene.
        """
        before = self._scene
        if scene.manifest_id == before.manifest_id or (self._greeted and not self._follows):
            return
        if not is_later(scene, before):
            if is_later(before, scene):  # it was read before this session began
                return
            raise ProtocolError(Closing.SCENE_CHANGED, "another scene has taken its place")
        self._scene = scene
        self._playhead.set(self._playhead.at(clock), clock)
        self._playhead.end, self._playhead.grows = scene.end, scene.live is not None
        if not self._greeted:
            return
        self._order.grow(scene, self._limits.splats)
        if self._current is not None and self._current.id not in scene.stored:
            self._current = None  # a replaced page
        self._ended = False
        wanted = scene.stored if self._limits.audio else scene.sizes
        remaining = sum(size for chunk, size in wanted.items() if chunk not in before.stored)
        self._outbox.append(encode(Grow(scene.manifest_id, remaining, scene.manifest)))

    def wait(self, clock: float) -> float | None:
        """Return the seconds until `take` has more without a message of the client; None if it never has."""
        return self._flow.wait(clock)

    def miss(self, part: ChunkPart) -> None:
        """Skip the chunk of the frame just returned by `take`, because it cannot be read."""
        chunk = part.chunk
        self._flow.refund(part.length)
        self._offsets.pop(chunk.id, None)
        self._order.settle(chunk)
        if self._current is not None and self._current == chunk:
            self._current = None
        self._outbox.append(encode(Missing(chunk.id)))

    def _greet(self, hello: Hello, clock: float) -> None:
        scene = self._scene
        cache = ClientCache.of(hello, scene)
        self._offsets = cache.parts
        self._greeted = True
        self._follows = hello.follow
        self._flow.grant(hello.credits)
        self._order = SendOrder(scene, cache.whole)
        self._limit(Limits(hello.splats, hello.bytes_per_second, audio=hello.audio))
        self._playhead.set(scene.start if hello.time is None else hello.time, clock, hello.rate)
        remaining = cache.lacking(scene.stored if hello.audio else scene.sizes)
        known = hello.manifest_id == scene.manifest_id
        manifest = b"" if known else scene.manifest
        welcome = Welcome(PROTOCOL_VERSION, scene.scene_id, manifest, scene.manifest_id, remaining)
        self._outbox.append(encode(welcome))

    def _limit(self, limits: Limits) -> None:
        if limits.splats != self._limits.splats:
            self._order.limit(limits.splats)
            self._ended = False
        if limits.audio != self._limits.audio:
            self._order.hear(limits.audio)
            self._ended = False
        self._limits, self._flow.bytes_per_second = limits, limits.bytes_per_second
        self._flow.measured = limits.measured

    def _seek(self, time: float, clock: float) -> None:
        self._playhead.set(time, clock)
        self._current = None
        self._order.sought(self._playhead.time)

    def _choose(self, clock: float) -> Chunk | None:
        """Return the next chunk to send; announce the slices found complete on the way."""
        order = self._order
        chunk = order.next(self._playhead.at(clock), self._playhead.rate, self._limits.measured)
        while order.marks:
            self._announce(order.marks.popleft())
        if chunk is None and not self._ended:
            self._ended = True
            self._outbox.append(encode(End(self._flow.sent_bytes, order.left_out)))
        return chunk

    def _announce(self, mark: Mark) -> None:
        piece = self._scene.slices[mark.index]
        self._outbox.append(encode(SliceSent(mark.index, piece.start, piece.end, mark.layer)))

    def _part(self, chunk: Chunk, clock: float) -> ChunkPart | None:
        """Cut the next part of the chunk to the credit, and charge it."""
        offset = self._offsets.get(chunk.id, 0)
        rest = chunk.size - offset
        length = self._flow.spend(rest, clock)
        if length is None:
            return None
        if length < rest:
            self._offsets[chunk.id] = offset + length
            self._current = chunk
        else:
            self._offsets.pop(chunk.id, None)
            self._order.settle(chunk)
            self._current = None
        return ChunkPart(chunk, offset, length, self._scene.page_bytes.get(chunk.id))
