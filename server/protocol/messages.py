"""Messages of the streaming protocol as typed dataclasses; docs/stream.md is normative.

A control message is one msgpack map whose `type` names its dataclass; a chunk frame is a fixed header and raw bytes.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import ClassVar

import msgpack

from server.protocol.stream_endings import Closing

__all__ = [
    "CHUNK_FRAME",
    "DEFAULT_RATE",
    "HEADER_BYTES",
    "MAX_BALANCE",
    "MAX_HAVE",
    "MAX_MESSAGE_BYTES",
    "MAX_PAGES",
    "MAX_PARTS",
    "MAX_PAYLOAD",
    "MAX_RATE",
    "MIN_PAYLOAD",
    "MIN_RATE_LIMIT",
    "PROTOCOL_VERSION",
    "ClientMessage",
    "Credit",
    "End",
    "Error",
    "Grow",
    "Hello",
    "Limits",
    "Missing",
    "Pause",
    "Ping",
    "Play",
    "Pong",
    "ProtocolError",
    "Seek",
    "ServerMessage",
    "SliceSent",
    "Welcome",
    "chunk_header",
    "encode",
]

PROTOCOL_VERSION = 1

MAX_MESSAGE_BYTES = 1 << 20  # a client's message; holds a full have-list
MAX_HAVE = 1 << 14  # chunk ids
MAX_PAGES = 1 << 14
MAX_PARTS = 1 << 10  # chunks that the client keeps in part
MAX_BALANCE = 1 << 26  # bytes of credit
MAX_RATE = 16.0  # scene seconds per second
MAX_PAYLOAD = 1 << 16  # bytes in one chunk frame: a seek waits for at most one of them
MIN_RATE_LIMIT = 1 << 12  # bytes per second
MIN_PAYLOAD = 1 << 12  # smaller pieces would waste the connection on headers
DEFAULT_RATE = 1.0

CHUNK_FRAME = 0x01  # first byte of a chunk frame; no msgpack map begins with it
_HEADER = struct.Struct("<B3xII4x32s")  # type, offset, size of the chunk, chunk id
HEADER_BYTES = _HEADER.size


class ProtocolError(Exception):
    """A breach of the protocol, or another end of the stream: the connection closes after an `error` message."""

    def __init__(self, closing: Closing, detail: str) -> None:
        """Keep the way of closing, and one line for people."""
        self.closing = closing
        self.detail = detail
        super().__init__(detail)


@dataclass(frozen=True)
class Hello:
    """The client's first message."""

    type: ClassVar[str] = "hello"
    protocol: int
    credits: int  # bytes: the first grant
    have: frozenset[bytes] = frozenset()  # ids of complete chunks the client keeps
    parts: Mapping[bytes, int] = field(default_factory=dict)  # first bytes of chunks that it keeps: id -> how many
    pages: Mapping[bytes, bytes] = field(default_factory=dict)  # kept pages, with a bit for each chunk they list
    manifest_id: bytes | None = None  # SHA-256 of the index that it keeps
    time: float | None = None  # seconds; None is the scene's start
    rate: float = DEFAULT_RATE  # scene seconds per second
    splats: int | None = None  # most in a picture; None is any number
    bytes_per_second: int | None = None  # most, in chunk frames; None is any number
    audio: bool = False  # whether the client wants the scene's sound
    follow: bool = False  # whether the client accepts additions to a growing scene


@dataclass(frozen=True)
class Credit:
    """A grant of `bytes` more bytes of chunk frames, headers included."""

    type: ClassVar[str] = "credit"
    bytes: int


@dataclass(frozen=True)
class Seek:
    """Move the playhead to `time` seconds, and send the chunks visible there first."""

    type: ClassVar[str] = "seek"
    time: float


@dataclass(frozen=True)
class Play:
    """Start the playhead from `time` seconds at `rate`."""

    type: ClassVar[str] = "play"
    time: float
    rate: float


@dataclass(frozen=True)
class Pause:
    """Stop the playhead at `time` seconds."""

    type: ClassVar[str] = "pause"
    time: float


@dataclass(frozen=True)
class Limits:
    """The client's current limits, which replace earlier ones; None is no limit, or unknown."""

    type: ClassVar[str] = "limits"
    splats: int | None = None  # splats per picture
    bytes_per_second: int | None = None  # rate of chunk frames
    measured: int | None = None  # measured throughput of the connection, bytes per second
    audio: bool = False  # whether the client wants the scene's sound


@dataclass(frozen=True)
class Ping:
    """A ping; the server answers at once with a `Pong` of the same id."""

    type: ClassVar[str] = "ping"
    id: int


@dataclass(frozen=True)
class Welcome:
    """Answers `Hello`: the scene's index, and how many bytes of chunks are to come."""

    type: ClassVar[str] = "welcome"
    protocol: int
    scene: str
    manifest: bytes  # index.hgs; empty if the client keeps that of `manifest_id`
    manifest_id: bytes  # its SHA-256
    remaining: int


@dataclass(frozen=True)
class Grow:
    """Notice that the scene has grown."""

    type: ClassVar[str] = "grow"
    manifest_id: bytes  # the SHA-256 of the new index
    remaining: int  # bytes of chunks to come
    manifest: bytes  # the new index


@dataclass(frozen=True)
class SliceSent:
    """The chunks of the slice `index`, [start, end] in seconds, have been sent, were in the have-list or are missing.

    Of layer 0 those of its base; of layer 1 all of them.
    """

    type: ClassVar[str] = "slice"
    index: int
    start: float
    end: float
    layer: int


@dataclass(frozen=True)
class Missing:
    """The server cannot read the chunk `id`, and goes on without it."""

    type: ClassVar[str] = "missing"
    id: bytes


@dataclass(frozen=True)
class Pong:
    """The answer to `Ping`."""

    type: ClassVar[str] = "pong"
    id: int


@dataclass(frozen=True)
class End:
    """Notice that the client has the scene, except for data beyond its limits; `bytes` of chunks were sent."""

    type: ClassVar[str] = "end"
    bytes: int
    left_out: int  # bytes


@dataclass(frozen=True)
class Error:
    """The reason for closing the connection."""

    type: ClassVar[str] = "error"
    code: str
    detail: str


ClientMessage = Hello | Credit | Seek | Play | Pause | Limits | Ping
ServerMessage = Welcome | Grow | SliceSent | Missing | Pong | End | Error


def encode(message: ServerMessage | ClientMessage) -> bytes:
    """Return the message as msgpack; fields that are None or false are left out."""
    fields = {name: value for name, value in asdict(message).items() if value is not None and value is not False}
    if isinstance(message, Hello):
        fields["have"] = sorted(message.have)
        fields["parts"] = [[chunk, offset] for chunk, offset in message.parts.items()]
        fields["pages"] = [[page, bits] for page, bits in message.pages.items()]
        if not message.pages:
            del fields["pages"]
    packed: bytes = msgpack.packb({"type": message.type, **fields}, use_bin_type=True)
    return packed


def chunk_header(chunk: bytes, offset: int, size: int) -> bytes:
    """Return the header of a frame that carries bytes from `offset` of the chunk of `size` bytes and 32-byte id."""
    return _HEADER.pack(CHUNK_FRAME, offset, size, chunk)
