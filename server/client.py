"""A client of the stream in Python, as docs/protocol.md describes one: for tests, `hgs bench stream` and `hgs play`."""

from __future__ import annotations

import asyncio
import contextlib
import gzip
import hashlib
import json
import random
import struct
import time
from collections.abc import Callable
from typing import Any

import msgpack
import websockets
from websockets.asyncio.client import ClientConnection

from hgs_core.base.errors import InputError
from hgs_core.codec.format.growth import apply_growth
from hgs_core.codec.format.manifest import Manifest
from hgs_core.codec.format.paged_manifest import PagedManifest, read_index
from server.client_hello import hello_of
from server.playback import Throughput
from server.protocol import (
    CHUNK_FRAME,
    HEADER_BYTES,
    LAST_WITHOUT_PAGES,
    PROTOCOL_VERSION,
    Credit,
    Limits,
    Ping,
    encode,
)

__all__ = ["StreamClient", "StreamRefusedError"]

SMALLEST_WINDOW = 64 << 10  # bytes
LARGEST_WINDOW = 2 << 20
SHORTEST_TRIP = 0.05  # seconds
FIRST_RETRY = 0.5  # seconds; doubled with each attempt
LAST_RETRY = 8.0
PASSING = frozenset({1006, 1011, 1012, 4008})  # close codes after which a client comes back
TELL_SECONDS = 1.0  # between two messages of how fast the line is
TOLD_CHANGE = 1.2


class StreamRefusedError(Exception):
    """The server has closed the stream for a reason that trying again does not cure."""


class StreamClient:
    """Receives a scene and keeps it in memory; comes back with what it has after a broken connection, and follows a
    scene that grows.

    `run` receives until it is cancelled. `arrived` is called whenever `manifest` or `have` may have changed.
    """

    def __init__(
        self,
        url: str,
        *,
        at: float | None = None,
        rate: float = 0.0,
        protocol: int = PROTOCOL_VERSION,
        splats: int | None = None,
        audio: bool = False,
        arrived: Callable[[], None] = lambda: None,
    ) -> None:
        """Receive the scene of `url`, ws://host/v1/scenes/{scene}/stream, first what is shown `at` that second.

        With `audio` its sound comes, too, and `have` holds the pieces that the manifest's `audio` names.
        """
        self.have: dict[str, bytes] = {}
        self.missing: set[str] = set()
        self.complete = False  # but for what limits leave out
        self.payload = 0  # bytes of chunks that have come
        self.twice = 0  # of them, bytes that had come before
        self.wire = 0  # bytes of all messages that have come
        self.manifests = 0  # that have come
        self.connections = 0
        self.line = Throughput()
        self._url, self._protocol, self._splats, self._audio = url, protocol, splats, audio
        self._arrived = arrived
        self._place, self._rate = at, rate
        self._parts: dict[str, bytearray] = {}
        self._manifest_id: bytes | None = None
        self._paged: PagedManifest | None = None
        self._document: dict[str, Any] = {}  # of the manifest, in versions 1 and 2
        self._socket: ClientConnection | None = None
        self._window = self._granted = 0
        self._trip = SHORTEST_TRIP
        self._pinged: float | None = None
        self._told = (0.0, 0.0)  # when, and bytes per second

    @property
    def manifest(self) -> Manifest | None:
        """The manifest, as far as its pages have come; another object whenever more of it has."""
        return None if self._paged is None else self._paged.manifest

    async def run(self) -> None:
        """Receive; return when the client has closed the stream.

        Raises:
            StreamRefusedError: the server has refused the stream.
        """
        failures = 0
        while True:
            before = self.payload
            try:
                async with websockets.connect(
                    self._url, compression=None, max_size=None, ping_interval=None
                ) as self._socket:
                    self.connections += 1
                    await self._listen(self._socket)
                return
            except websockets.ConnectionClosed as closed:
                code = 1006 if closed.rcvd is None else closed.rcvd.code
                if code not in PASSING:
                    raise StreamRefusedError(f"the server closed the stream: {code}") from closed
            except OSError:
                pass
            finally:
                self._socket = None
            failures = 0 if self.payload > before else failures + 1
            await asyncio.sleep(random.random() * min(LAST_RETRY, FIRST_RETRY * 2**failures))

    async def send(self, message: Any) -> None:
        """Send a message of `server.protocol`, if there is a connection; note the playhead for the next one."""
        if hasattr(message, "time"):
            self._place = message.time
        self._rate = getattr(message, "rate", self._rate)
        if self._socket is not None:
            with contextlib.suppress(websockets.ConnectionClosed):
                await self._socket.send(encode(message))

    async def close(self) -> None:
        """Leave for good."""
        if self._socket is not None:
            await self._socket.close(1000)

    def drop(self) -> None:
        """Break the connection, as a line does."""
        if self._socket is not None:
            self._socket.transport.abort()

    async def _listen(self, socket: ClientConnection) -> None:
        try:
            await self._greet(socket)
            async for message in socket:
                await self._receive(bytes(message) if isinstance(message, bytes) else message.encode())
        except asyncio.CancelledError:
            self.drop()  # a farewell would wait behind what is on its way
            raise

    async def _greet(self, socket: ClientConnection) -> None:
        self._window = self._granted = SMALLEST_WINDOW
        self._told = (0.0, 0.0)
        hello = hello_of(
            self._protocol,
            SMALLEST_WINDOW,
            paged=self._paged,
            have=self.have,
            parts=self._parts,
            manifest_id=self._manifest_id,
            time=self._place,
            rate=self._rate,
            splats=self._splats,
            audio=self._audio,
        )
        await socket.send(encode(hello))
        self._pinged = time.monotonic()
        await socket.send(encode(Ping(0)))

    async def _receive(self, message: bytes) -> None:
        self.wire += len(message)
        if message[0] == CHUNK_FRAME:
            await self._frame(message)
        else:
            self._control(msgpack.unpackb(message))
        self._arrived()

    def _control(self, message: dict[str, Any]) -> None:
        match message["type"]:
            case "welcome" if message["manifest"]:
                self.manifests += 1
                self._become(message, message["manifest"])
            case "grow" if "manifest" in message:
                self._become(message, message["manifest"])
            case "grow":
                self._read(apply_growth(self._document, _json(message, "growth")), message["manifest_id"])
            case "pong" if self._pinged is not None:
                self._trip = max(SHORTEST_TRIP, time.monotonic() - self._pinged)
                self._pinged = None
            case "missing":
                self.missing.add(message["id"].hex())
                self._parts.pop(message["id"].hex(), None)
            case "end":
                self.complete = True
            case "error":
                raise StreamRefusedError(f"{message['code']}: {message['detail']}")

    def _become(self, message: dict[str, Any], manifest: bytes) -> None:
        paged = self._protocol > LAST_WITHOUT_PAGES
        document = read_index(manifest, self._url) if paged else _json(message, "manifest")
        self._read(document, message["manifest_id"])

    def _read(self, document: dict[str, Any], manifest_id: bytes) -> None:
        later = PagedManifest(document, f"manifest of {self._url}")
        if self._paged is None:
            self._paged = later
        elif self._paged.continued_by(later):
            self._paged.become(later)
        else:
            raise StreamRefusedError("another scene has taken its place")
        self._document, self._manifest_id, self.complete = document, manifest_id, False

    async def _frame(self, message: bytes) -> None:
        offset, size = struct.unpack_from("<II", message, 4)
        name, payload = message[16:HEADER_BYTES].hex(), message[HEADER_BYTES:]
        part = self._parts.setdefault(name, bytearray())
        if name in self.have or offset != len(part):
            self.twice += len(payload)
        part[offset:] = payload
        self.payload += len(payload)
        if len(part) == size:
            data = bytes(self._parts.pop(name))
            if hashlib.sha256(data).hexdigest() != name:
                raise StreamRefusedError(f"chunk {name} has come damaged")
            self._take(name, data)
        now = time.monotonic()
        self.line.count(len(message), now)
        await self._grant(len(message), now)

    def _take(self, name: str, data: bytes) -> None:
        if self._paged is None or not self._paged.lacks(name):
            self.have[name] = data
            return
        try:
            self._paged.add(name, data)
        except InputError as error:
            raise StreamRefusedError(str(error)) from error

    async def _grant(self, received: int, now: float) -> None:
        """Give credit back in quarters of the window, which is twice what the line carries in a round trip."""
        self._granted -= received
        rate = self.line.rate(now)
        wanted = 2 * rate * self._trip if rate else self._window + received
        self._window = int(min(LARGEST_WINDOW, max(SMALLEST_WINDOW, wanted)))
        room = self._window - self._granted
        if room >= self._window / 4:
            self._granted += room
            await self.send(Credit(room))
        at, told = self._told
        same = told / TOLD_CHANGE < rate < told * TOLD_CHANGE
        if self._protocol > 1 and rate and now - at >= TELL_SECONDS and not same:
            self._told = (now, rate)
            await self.send(Limits(splats=self._splats, measured=int(rate), audio=self._audio))


def _json(message: dict[str, Any], field: str) -> dict[str, Any]:
    data = message[field]
    document: dict[str, Any] = json.loads(gzip.decompress(data) if message.get("coding") == "gzip" else data)
    return document
