"""A client of the stream in Python, as docs/stream.md describes one: for tests, `hgs bench stream` and `hgs play`."""

from __future__ import annotations

import asyncio
import contextlib
import random
import struct
import time
from collections.abc import Callable
from typing import Any

import msgpack
import websockets
from websockets.asyncio.client import ClientConnection

from hgs_core.codec.format.paged_manifest import read_index
from server.client.client_hello import hello_of
from server.client.received_scene import ReceivedScene, StreamRefusedError
from server.client.scene_fetching import SceneFetching
from server.client.scene_files import AwayError, SceneFiles
from server.protocol.messages import (
    CHUNK_FRAME,
    HEADER_BYTES,
    Credit,
    Limits,
    Ping,
    encode,
)
from server.protocol.stream_endings import meaning, passes

__all__ = ["StreamClient", "StreamRefusedError"]

SMALLEST_WINDOW = 64 << 10  # bytes
LARGEST_WINDOW = 2 << 20
SHORTEST_TRIP = 0.05  # seconds
FIRST_RETRY = 0.5  # seconds; doubled with each attempt
LAST_RETRY = 8.0
FIRST_MESSAGE = 10.0  # seconds after a hello; on a line that brings nothing in that time nothing will come
DOUBTS = 2  # failures before any stream, with an answer over HTTP after each, until there is to be none
UPGRADE_NEEDED = 426  # the server's own word for a handshake without its Upgrade
TELL_SECONDS = 1.0  # between two messages of how fast the line is
TOLD_CHANGE = 1.2


class _SilentError(Exception):
    """A connection that was accepted brings nothing."""


class StreamClient(ReceivedScene):
    """Receives a scene and keeps it in memory; reconnects with its chunks after a broken connection, and follows a
    scene that grows. Where something on the way passes no WebSockets, or where the address is that of a folder on a web
    server, the scene is fetched over HTTP.

    `run` receives until it is cancelled. `arrived` is called whenever `manifest` or `have` may have changed.
    """

    def __init__(
        self,
        url: str,
        *,
        at: float | None = None,
        rate: float = 0.0,
        splats: int | None = None,
        audio: bool = False,
        key: str = "",
        arrived: Callable[[], None] = lambda: None,
    ) -> None:
        """Receive the scene of `url`, ws://host/v1/scenes/{scene}/stream, first the chunks shown `at` that second.

        `url` may be that of a scene's folder, manifest.json or index.hgs on a web server, too. With `audio` the scene's
        sound comes, and `have` holds the pieces that the manifest's `audio` names. `key` is what the server asks for.
        """
        super().__init__(url, arrived)
        self.connections = 0
        self.over_http = not url.startswith("ws")  # or has become so, for want of a stream
        self._splats, self._audio, self._key = splats, audio, key
        self._place, self._rate, self._placed = at, rate, time.monotonic()
        self._parts: dict[str, bytearray] = {}
        self._manifest_id: bytes | None = None
        self._socket: ClientConnection | None = None
        self._closed = asyncio.Event()
        self._window = self._granted = 0
        self._trip = SHORTEST_TRIP
        self._pinged: float | None = None
        self._told = (0.0, 0.0)  # moment, bytes per second

    async def run(self) -> None:
        """Receive; return when the client has closed the stream.

        Raises:
            StreamRefusedError: the server has refused the stream.
        """
        failures = doubts = 0
        while not self.over_http:
            before, doubt = self.payload, 1
            try:
                await self._connect()
                if self._closed.is_set():
                    return
            except websockets.ConnectionClosed as closed:
                if self._closed.is_set():
                    return
                code = 1006 if closed.rcvd is None else closed.rcvd.code
                if not passes(code):
                    raise StreamRefusedError(f"the server closed the stream ({code}): {meaning(code)}") from closed
            except websockets.InvalidStatus as error:
                doubt = DOUBTS if error.response.status_code == UPGRADE_NEEDED else 1
            except _SilentError:
                doubt = DOUBTS
            except (OSError, websockets.InvalidHandshake):
                pass
            finally:
                self._socket = None
            # One connection that fails while HTTP is answered may be that of a server that restarts.
            doubts = doubts + doubt if self.paged is None and await self._answered_over_http() else 0
            self.over_http = doubts >= DOUBTS
            failures = 0 if self.payload > before else failures + 1
            if not self.over_http:
                await asyncio.sleep(random.random() * min(LAST_RETRY, FIRST_RETRY * 2**failures))
        await SceneFetching(self, self._files(), self._playhead, splats=self._splats, audio=self._audio).run()
        await self._closed.wait()

    async def _connect(self) -> None:
        headers = {"Authorization": f"Bearer {self._key}"} if self._key else None
        async with websockets.connect(
            self.url, compression=None, max_size=None, ping_interval=None, additional_headers=headers
        ) as self._socket:
            self.connections += 1
            await self._listen(self._socket)

    def _files(self) -> SceneFiles:
        place = SceneFiles.beside if self.url.startswith("ws") else SceneFiles.at
        return place(self.url, self._key)

    async def _answered_over_http(self) -> bool:
        """Return whether the scene can be had without a stream.

        Raises:
            StreamRefusedError: it is refused in this way, too.
        """
        try:
            return await self._files().manifest() is not None
        except AwayError:
            return False

    def _playhead(self) -> tuple[float | None, float]:
        """Return where the playhead is, and its rate."""
        place = self._place
        return None if place is None else place + self._rate * (time.monotonic() - self._placed), self._rate

    async def send(self, message: Any) -> None:
        """Send a message of `server.protocol.messages` if there is a connection; note the playhead for the next one."""
        if hasattr(message, "time"):
            self._place, self._placed = message.time, time.monotonic()
        self._rate = getattr(message, "rate", self._rate)
        if self._socket is not None:
            with contextlib.suppress(websockets.ConnectionClosed):
                await self._socket.send(encode(message))

    async def close(self) -> None:
        """Leave for good."""
        self._closed.set()
        if self._socket is not None:
            await self._socket.close(1000)

    def drop(self) -> None:
        """Break the connection, as a line does."""
        if self._socket is not None:
            self._socket.transport.abort()

    async def _listen(self, socket: ClientConnection) -> None:
        try:
            await self._greet(socket)
            try:
                async with asyncio.timeout(FIRST_MESSAGE):
                    first = await socket.recv(decode=False)
            except TimeoutError:
                self.drop()
                raise _SilentError from None
            await self._receive(first)
            async for message in socket:
                await self._receive(bytes(message) if isinstance(message, bytes) else message.encode())
        except asyncio.CancelledError:
            self.drop()  # a farewell would wait behind what is on its way
            raise

    async def _greet(self, socket: ClientConnection) -> None:
        self._window = self._granted = SMALLEST_WINDOW
        self._told = (0.0, 0.0)
        hello = hello_of(
            SMALLEST_WINDOW,
            paged=self.paged,
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
        self.arrived()

    def _control(self, message: dict[str, Any]) -> None:
        match message["type"]:
            case "welcome" if message["manifest"]:
                self.manifests += 1
                self._become(message, message["manifest"])
            case "grow":
                self._become(message, message["manifest"])
            case "pong" if self._pinged is not None:
                self._trip = max(SHORTEST_TRIP, time.monotonic() - self._pinged)
                self._pinged = None
            case "missing":
                self.missing.add(message["id"].hex())
                self._parts.pop(message["id"].hex(), None)
            case "end":
                self.complete = True
            case "error" if not passes(message["code"]):
                raise StreamRefusedError(f"{message['code']}: {meaning(message['code']) or message['detail']}")

    def _become(self, message: dict[str, Any], manifest: bytes) -> None:
        self.become(read_index(manifest, self.url))
        self._manifest_id = message["manifest_id"]

    async def _frame(self, message: bytes) -> None:
        offset, size = struct.unpack_from("<II", message, 4)
        name, payload = message[16:HEADER_BYTES].hex(), message[HEADER_BYTES:]
        part = self._parts.setdefault(name, bytearray())
        if name in self.have or offset != len(part):
            self.twice += len(payload)
        part[offset:] = payload
        self.payload += len(payload)
        if len(part) == size:
            self.take(name, bytes(self._parts.pop(name)))
        now = time.monotonic()
        self.line.count(len(message), now)
        await self._grant(len(message), now)

    async def _grant(self, received: int, now: float) -> None:
        """Give credit back in quarters of the window, which holds two round trips of the line."""
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
        if rate and now - at >= TELL_SECONDS and not same:
            self._told = (now, rate)
            await self.send(Limits(splats=self._splats, measured=int(rate), audio=self._audio))
