"""Viewers on bad lines, of bad stores and with bad manners, on a real server."""

from __future__ import annotations

import asyncio
import hashlib
import json
import select
import socket
import sys
from typing import Any

import httpx
import pytest
import websockets
from websockets.asyncio.client import ClientConnection

from server.listener import websocket_protocol
from server.protocol.messages import MAX_PAYLOAD, Hello, Ping, Seek, encode
from server.routes import stream
from server.scenes import chunk_cache
from server.scenes.chunk_cache import ChunkCache
from server.scenes.scene_index import Chunk
from server.stream.stream_session import StreamSession
from tests.chunks import static_chunk
from tests.server.listener.test_http_server import receive, receive_all, with_stream
from tests.studio_scene import small_manifest

PATH = "/v1/scenes/studio/stream"


def test_missing_and_damaged_chunks_cost_themselves_and_may_be_mended(
    server: Any, manifest: bytes, chunks: list[bytes], monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(chunk_cache, "RETRY_SECONDS", 0.0)
    names = [hashlib.sha256(chunk).hexdigest() for chunk in chunks]

    async def talk(socket: ClientConnection) -> None:
        for mended in (False, True):
            stored = server.artifacts.chunks
            stored.pop(names[1])
            stored[names[3]] = chunks[3] if mended else b"damaged"
            async with websockets.connect(f"ws://127.0.0.1:{socket.remote_address[1]}{PATH}") as viewer:
                await viewer.send(encode(Hello(1, 100_000)))
                received, messages = await receive_all(viewer, 100_000)
            lost = [names[1]] if mended else [names[1], names[3]]
            assert {message["id"].hex() for message in messages if message["type"] == "missing"} == set(lost)
            assert {chunk.hex() for chunk in received} == set(names) - set(lost)
            assert {message["index"] for message in messages if message["type"] == "slice"} == {0, 1, 2}
            assert messages[-1]["bytes"] == sum(map(len, received.values()))
            server.artifacts.add_chunk(chunks[1])
        faults = [record for record in caplog.records if record.levelname == "ERROR"]
        assert len(faults) == 2  # one for each chunk, not for each viewer

    with_stream(server, manifest, chunks, talk)


def test_broken_connection_goes_on_in_the_middle_of_a_chunk(server: Any, manifest: bytes, chunks: list[bytes]) -> None:
    chunk_id = hashlib.sha256(chunks[0]).digest()

    async def talk(socket: ClientConnection) -> None:
        await socket.send(encode(Hello(1, 70_000)))
        welcome = await receive(socket)
        frame = await receive(socket)
        assert isinstance(welcome, dict)
        assert isinstance(frame, tuple)
        kept = {chunk_id: len(frame[3])}
        async with websockets.connect(f"ws://127.0.0.1:{socket.remote_address[1]}{PATH}") as viewer:
            await viewer.send(encode(Hello(1, 1 << 20, parts=kept, manifest_id=welcome["manifest_id"])))
            again = await receive(viewer)
            assert isinstance(again, dict)
            assert again["manifest"] == b""
            assert again["remaining"] == sum(map(len, chunks)) - len(frame[3])
            rest = await receive(viewer)
            assert isinstance(rest, tuple)
            assert (rest[0], rest[1]) == (chunk_id, len(frame[3]))
            assert chunks[0].startswith(frame[3] + rest[3])

    with_stream(server, manifest, chunks, talk)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux refuses to take more than TCP_NOTSENT_LOWAT allows")
def test_reader_that_stops_is_cut_off_and_holds_little_memory(server: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(websocket_protocol, "STALL_SECONDS", 1.0)
    chunks = [static_chunk(bytes([k]) * 200_000) for k in range(1, 31)]
    manifest = json.dumps(small_manifest(chunks[:-1], [(0.0, 1.0, chunks[-1:])]).to_json()).encode()
    frames = 0
    expect = ChunkCache.expect

    async def counted(self: ChunkCache, chunk: Chunk) -> bytes | None:
        nonlocal frames
        frames += 1
        return await expect(self, chunk)

    monkeypatch.setattr(ChunkCache, "expect", counted)

    async def talk(first: ClientConnection) -> None:
        loop = asyncio.get_running_loop()
        with socket.socket() as reader:
            reader.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            reader.setblocking(False)
            await loop.sock_connect(reader, first.remote_address)
            upgrade = f"GET {PATH} HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
            await loop.sock_sendall(reader, (upgrade + key).encode())
            assert (await loop.sock_recv(reader, 12)).endswith(b"101")
            hello = encode(Hello(1, 1 << 26))
            await loop.sock_sendall(reader, bytes([0x82, 0x80 | len(hello), 0, 0, 0, 0]) + hello)
            events = select.poll()
            events.register(reader, select.POLLERR)  # a reset; nothing is read
            assert await asyncio.to_thread(events.poll, 60_000)
        assert frames * MAX_PAYLOAD < 500_000

    with_stream(server, manifest, chunks, talk)


def test_flood_of_seeks_is_read_no_faster_than_allowed(
    server: Any, manifest: bytes, chunks: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stream, "MESSAGE_RATE", 1e-3)  # next to nothing above the burst
    seeks = 0
    seek = StreamSession._seek

    def counted(self: StreamSession, time: float, clock: float) -> None:
        nonlocal seeks
        seeks += 1
        seek(self, time, clock)

    monkeypatch.setattr(StreamSession, "_seek", counted)

    async def talk(socket: ClientConnection) -> None:
        await socket.send(encode(Hello(1, 1 << 20)))
        await receive_all(socket, 1 << 20)
        for _ in range(3000):
            await socket.send(encode(Seek(2.5)))
        async with websockets.connect(f"ws://127.0.0.1:{socket.remote_address[1]}{PATH}") as viewer:
            await viewer.send(encode(Hello(1, 1 << 20)))
            await receive_all(viewer, 1 << 20)
        assert 0 < seeks <= stream.MESSAGE_BURST + 100
        socket.transport.abort()

    with_stream(server, manifest, chunks, talk)


def test_grants_for_every_frame_are_no_flood(
    server: Any, manifest: bytes, chunks: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stream, "MESSAGE_RATE", 1e-3)
    monkeypatch.setattr(stream, "MESSAGE_BURST", 5.0)

    async def talk(socket: ClientConnection) -> None:
        await socket.send(encode(Hello(1, 4144)))
        received, _ = await receive_all(socket, 4144)
        assert len(received) == len(chunks)

    with_stream(server, manifest, chunks, talk)


def test_viewers_are_told_when_their_scene_is_deleted(server: Any, manifest: bytes, chunks: list[bytes]) -> None:
    async def talk(socket: ClientConnection) -> None:
        await socket.send(encode(Hello(1, 0)))  # it waits for credit, as a paused viewer does
        welcome = await receive(socket)
        assert isinstance(welcome, dict)
        address = f"http://127.0.0.1:{socket.remote_address[1]}/v1/scenes/studio"
        async with httpx.AsyncClient() as client:
            assert (await client.delete(address)).status_code == 204
            assert (await client.delete(address)).status_code == 404
        error = await receive(socket)
        assert isinstance(error, dict)
        assert (error["type"], error["code"]) == ("error", "scene-not-found")
        await socket.wait_closed()
        assert socket.close_code == 4004

    with_stream(server, manifest, chunks, talk)


def test_stream_ends_with_a_bad_message_that_comes_together_with_a_good_one(
    server: Any, manifest: bytes, chunks: list[bytes]
) -> None:
    server.artifacts.manifests["studio"] = manifest
    for chunk in chunks:
        server.artifacts.add_chunk(chunk)
    hello = encode(Hello(1, 1 << 20, bytes_per_second=4096))  # the next frame waits for its time
    waiting = [{"bytes": b"\xff"}, {"bytes": encode(Ping(1))}, {"bytes": hello}, {"type": "websocket.connect"}]
    sent: list[Any] = []

    async def receive_next() -> Any:
        if len(waiting) == 2:
            await asyncio.sleep(0.05)  # the end of sending
        return {"type": "websocket.receive"} | waiting.pop()

    async def send(message: Any) -> None:
        sent.append(message)

    scope = {
        "type": "websocket",
        "path": PATH,
        "raw_path": PATH.encode(),
        "root_path": "",
        "scheme": "ws",
        "query_string": b"",
        "headers": [(b"host", b"localhost")],
        "client": ("127.0.0.1", 1),
        "server": ("127.0.0.1", 80),
        "subprotocols": [],
    }

    async def scenario() -> None:
        async with asyncio.timeout(30):
            await server.app(scope, receive_next, send)

    asyncio.run(scenario())
    assert sent[-1]["code"] == 4000


def test_a_request_that_has_lost_its_upgrade_is_told_so(server: Any, manifest: bytes) -> None:
    answer = server.get("/v1/scenes/studio/stream")
    assert (answer.status_code, answer.json()["code"]) == (426, "upgrade-needed")
    assert answer.headers["upgrade"] == "websocket"
    assert "docs/deploy.md" in answer.json()["detail"]
