"""The protocol's messages over QUIC, server and client: all on one stream, or every chunk on a stream of its own.

For scripts/experiments/lossy_lines.py; needs aioquic, which HGS does not. Messages are those of docs/protocol.md, each
behind its length (u32, little endian). Session, order, credits and what a client does are those of the WebSocket.
"""

from __future__ import annotations

import asyncio
import contextlib
import datetime
import ssl
import struct
import time
from collections import defaultdict
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any

from aioquic.asyncio import QuicConnectionProtocol, connect, serve
from aioquic.quic.configuration import QuicConfiguration
from aioquic.quic.events import ConnectionTerminated, QuicEvent, StreamDataReceived
from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from server.client.stream_client import StreamClient
from server.protocol.messages import chunk_header
from server.scenes.scene_index import SceneIndex
from server.stream.stream_session import StreamSession

__all__ = ["QuicStreamClient", "serving_quic"]

CONTROL = 0  # the stream of the client, on which control messages go both ways
UNSENT_BYTES = 32 << 10  # that wait in the library beyond what is on its way, as in the WebSocket's kernel
LOOK_SECONDS = 0.002
ALPN = ["hgs"]


class _Messages:
    """Puts messages together that come in pieces."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def add(self, data: bytes) -> list[bytes]:
        self._bytes += data
        found = []
        while len(self._bytes) >= 4 and len(self._bytes) >= 4 + (size := struct.unpack_from("<I", self._bytes)[0]):
            found.append(bytes(self._bytes[4 : 4 + size]))
            del self._bytes[: 4 + size]
        return found


def _framed(message: bytes) -> bytes:
    return struct.pack("<I", len(message)) + message


class _Speaker(QuicConnectionProtocol):
    """The server's side of one connection."""

    scene: SceneIndex
    chunks: Mapping[str, bytes]
    apart: bool  # whether every chunk has a stream of its own

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._session = StreamSession(self.scene)
        self._messages = _Messages()
        self._news = asyncio.Event()
        self._streams: dict[bytes, int] = {}
        self._speaking: asyncio.Task[None] | None = None

    def quic_event_received(self, event: QuicEvent) -> None:
        if isinstance(event, StreamDataReceived) and event.stream_id == CONTROL:
            for message in self._messages.add(event.data):
                self._session.receive(message, time.monotonic())
            self._news.set()
            if self._speaking is None:
                self._speaking = asyncio.create_task(self._speak())
        elif isinstance(event, ConnectionTerminated) and self._speaking is not None:
            self._speaking.cancel()

    async def _speak(self) -> None:
        while True:
            item = self._session.take(time.monotonic())
            if item is None:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(self._session.wait(time.monotonic())):
                        await self._news.wait()
                self._news.clear()
                continue
            if isinstance(item, bytes):
                self._quic.send_stream_data(CONTROL, _framed(item))
            else:
                data = self.chunks[item.chunk.id.hex()][item.offset : item.offset + item.length]
                frame = _framed(chunk_header(item.chunk.id, item.offset, item.chunk.size) + data)
                last = self.apart and item.offset + item.length == item.chunk.size
                self._quic.send_stream_data(self._stream(item.chunk.id), frame, end_stream=last)
            self.transmit()
            while self._unsent() > UNSENT_BYTES:
                await asyncio.sleep(LOOK_SECONDS)
            await asyncio.sleep(0)

    def _stream(self, chunk: bytes) -> int:
        if not self.apart:
            return CONTROL
        if chunk not in self._streams:
            self._streams[chunk] = self._quic.get_next_available_stream_id(is_unidirectional=True)
        return self._streams[chunk]

    def _unsent(self) -> int:
        senders = (stream.sender for stream in self._quic._streams.values())
        return sum(part.stop - part.start for sender in senders for part in sender._pending)


@asynccontextmanager
async def serving_quic(scene: SceneIndex, chunks: Mapping[str, bytes], host: str, apart: bool) -> AsyncIterator[int]:
    """Serve a scene to all who connect; gives the port."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "bench")])
    now = datetime.datetime.now(datetime.UTC)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=1))
        .sign(key, hashes.SHA256())
    )
    settings = QuicConfiguration(is_client=False, alpn_protocols=ALPN, congestion_control_algorithm="cubic")
    settings.certificate, settings.private_key = certificate, key
    speaker = type("Speaker", (_Speaker,), {"scene": scene, "chunks": chunks, "apart": apart})
    server = await serve(host, 4433, configuration=settings, create_protocol=speaker)
    try:
        yield 4433
    finally:
        server.close()


class _Listener(QuicConnectionProtocol):
    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self.came: asyncio.Queue[bytes | None] = asyncio.Queue()
        self._messages: defaultdict[int, _Messages] = defaultdict(_Messages)

    def quic_event_received(self, event: QuicEvent) -> None:
        if isinstance(event, StreamDataReceived):
            for message in self._messages[event.stream_id].add(event.data):
                self.came.put_nowait(message)
        elif isinstance(event, ConnectionTerminated):
            self.came.put_nowait(None)


class _Socket:
    """What `StreamClient` needs of a WebSocket."""

    def __init__(self, connection: _Listener) -> None:
        self._connection = connection
        self.transport = self

    async def send(self, message: bytes) -> None:
        self._connection._quic.send_stream_data(CONTROL, _framed(message))
        self._connection.transmit()

    def abort(self) -> None:
        self._connection.close()

    async def __aiter__(self) -> AsyncIterator[bytes]:
        while (message := await self._connection.came.get()) is not None:
            yield message


class QuicStreamClient(StreamClient):
    """The client over QUIC; one whose connection breaks does not come back."""

    async def run(self) -> None:
        """Receive until it is cancelled."""
        host, _, port = self._url.split("/")[2].partition(":")
        settings = QuicConfiguration(is_client=True, alpn_protocols=ALPN, congestion_control_algorithm="cubic")
        settings.verify_mode = ssl.CERT_NONE
        async with connect(host, int(port), configuration=settings, create_protocol=_Listener) as connection:
            assert isinstance(connection, _Listener)
            self._socket: Any = _Socket(connection)
            await self._listen(self._socket)
