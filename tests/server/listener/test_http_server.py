"""A real uvicorn on a loopback socket, a real WebSocket client, real event streams."""

from __future__ import annotations

import asyncio
import contextlib
import gc
import hashlib
import json
import math
import struct
import threading
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Any

import httpx
import msgpack
import pytest
import websockets
from websockets.asyncio.client import ClientConnection

from hgs_core.base.errors import InputError
from jobs.artifacts.artifact_store import SceneEntry
from jobs.records.job import JobState
from server.listener import http_server
from server.listener.http_server import bind, spare_collector
from server.protocol.messages import MAX_MESSAGE_BYTES, Credit, Hello, Ping, Seek, encode
from server.routes import stream
from server.scenes.scene_index import read_scene
from tests.server.conftest import running_server


@contextlib.asynccontextmanager
async def running(app: Any) -> AsyncIterator[str]:
    """Serve on a port of the system's choice; yield host:port."""
    async with running_server(app) as (_, address):
        yield address


def with_stream(
    server: Any, manifest: bytes, chunks: list[bytes], talk: Callable[[ClientConnection], Awaitable[None]]
) -> None:
    """Let `talk` have a connection to the stream of the scene `studio`."""
    server.artifacts.manifests["studio"] = manifest
    for chunk in chunks:
        server.artifacts.add_chunk(chunk)

    async def scenario() -> None:
        async with (
            running(server.app) as address,
            websockets.connect(f"ws://{address}/v1/scenes/studio/stream", max_size=None) as socket,
        ):
            await talk(socket)

    asyncio.run(scenario())


async def receive(socket: ClientConnection) -> dict[str, Any] | tuple[bytes, int, int, bytes]:
    """Return a control message, or (chunk id, offset, size, payload) of a chunk frame."""
    message = await asyncio.wait_for(socket.recv(decode=False), 30)
    if message[0] == 0x01:
        offset, size, chunk_id = struct.unpack_from("<II4x32s", message, 4)
        return chunk_id, offset, size, message[48:]
    control: dict[str, Any] = msgpack.unpackb(message)
    return control


async def receive_all(socket: ClientConnection, window: int) -> tuple[dict[bytes, bytearray], list[dict[str, Any]]]:
    """Receive until `end`, granting the received bytes back; return the chunks in order of arrival and the messages."""
    chunks: dict[bytes, bytearray] = {}
    messages: list[dict[str, Any]] = []
    while not messages or messages[-1]["type"] != "end":
        item = await receive(socket)
        if isinstance(item, dict):
            messages.append(item)
            continue
        chunk_id, offset, size, payload = item
        chunk = chunks.setdefault(chunk_id, bytearray())
        assert offset == len(chunk)
        chunk += payload
        assert len(chunk) <= size
        assert 48 + len(payload) <= window
        await socket.send(encode(Credit(48 + len(payload))))
    return chunks, messages


@pytest.mark.parametrize("window", [4144, 100_000, 1 << 24])
def test_stream_carries_the_whole_scene_within_any_window(
    server: Any, manifest: bytes, chunks: list[bytes], window: int
) -> None:
    async def talk(socket: ClientConnection) -> None:
        await socket.send(encode(Hello(1, window)))
        received, messages = await receive_all(socket, window)
        assert messages[0]["manifest"] == read_scene("studio", manifest).manifest
        order = [chunks[0], chunks[2], chunks[3], chunks[4], chunks[1]]  # a detail of the room comes last
        assert [bytes(chunk) for chunk in received.values()] == order
        assert list(received) == [hashlib.sha256(chunk).digest() for chunk in order]
        assert sorted(m["index"] for m in messages if m["type"] == "slice") == [0, 0, 1, 1, 2, 2]

    with_stream(server, manifest, chunks, talk)


def test_seek_on_a_full_line_gets_the_new_time_first(server: Any, manifest: bytes, chunks: list[bytes]) -> None:
    async def talk(socket: ClientConnection) -> None:
        await socket.send(encode(Hello(1, 4144)))
        await receive(socket)
        await receive(socket)
        await socket.send(encode(Seek(2.5)))
        await socket.send(encode(Credit(4144)))
        item = await receive(socket)
        assert isinstance(item, tuple)
        # The slice of 2.5 s needs the chunk of the slice before it too.
        assert item[0] == hashlib.sha256(chunks[3]).digest()

    with_stream(server, manifest, chunks, talk)


def test_ping_is_answered_without_credit(server: Any, manifest: bytes, chunks: list[bytes]) -> None:
    async def talk(socket: ClientConnection) -> None:
        await socket.send(encode(Hello(1, 0)))
        await socket.send(encode(Ping(2**64 - 1)))
        assert [(await receive(socket))["type"] for _ in range(2)] == ["welcome", "pong"]  # type: ignore[call-overload]

    with_stream(server, manifest, chunks, talk)


@pytest.mark.parametrize(
    ("message", "close_code", "code"),
    [
        (b"\xff", 4000, "malformed"),
        (encode(Seek(0.0)), 4000, "malformed"),
        (msgpack.packb({"type": "hello", "protocol": 9}), 4001, "protocol-unsupported"),
        (encode(Hello(1, 1 << 40)), 4009, "credit-overflow"),
        ("text", 1003, "not-binary"),
        (bytes(MAX_MESSAGE_BYTES + 1), 1009, "message-too-large"),
    ],
    ids=["not msgpack", "no hello", "version 9", "too much credit", "text", "too large"],
)
def test_broken_protocol_is_told_and_closed(
    server: Any, manifest: bytes, chunks: list[bytes], message: bytes | str, close_code: int, code: str
) -> None:
    async def talk(socket: ClientConnection) -> None:
        await socket.send(message)
        error = await receive(socket)
        assert isinstance(error, dict)
        assert (error["type"], error["code"]) == ("error", code)
        await asyncio.wait_for(socket.wait_closed(), 30)
        assert socket.close_code == close_code

    with_stream(server, manifest, chunks, talk)


def test_silent_client_is_closed(
    server: Any, manifest: bytes, chunks: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stream, "HELLO_SECONDS", 0.05)

    async def talk(socket: ClientConnection) -> None:
        await asyncio.wait_for(socket.wait_closed(), 30)
        assert socket.close_code == 4008

    with_stream(server, manifest, chunks, talk)


@pytest.mark.parametrize(
    ("scene", "close_code", "code"), [("nothing", 4004, "scene-not-found"), ("broken", 1011, "internal")]
)
def test_scene_that_cannot_be_opened_is_told_and_closed(server: Any, scene: str, close_code: int, code: str) -> None:
    server.artifacts.manifests["broken"] = b"{}"

    async def scenario() -> None:
        async with (
            running(server.app) as address,
            websockets.connect(f"ws://{address}/v1/scenes/{scene}/stream") as socket,
        ):
            error = await receive(socket)
            assert isinstance(error, dict)
            assert error["code"] == code
            await asyncio.wait_for(socket.wait_closed(), 30)
            assert socket.close_code == close_code

    asyncio.run(scenario())


def test_pages_of_other_origins_are_refused_before_the_upgrade(server: Any) -> None:
    async def scenario() -> None:
        async with running(server.app) as address:
            with pytest.raises(websockets.InvalidStatus) as caught:
                await websockets.connect(f"ws://{address}/v1/scenes/studio/stream", origin="https://elsewhere.example")
            response = caught.value.response
            assert response.status_code == 403
            assert response.headers["content-type"] == "application/problem+json"
            assert response.body is not None
            assert json.loads(response.body)["code"] == "origin-not-allowed"

    asyncio.run(scenario())


def test_shutdown_closes_streams_and_event_streams_at_once(server: Any, manifest: bytes) -> None:
    server.artifacts.manifests["studio"] = manifest
    job_id = server.request("POST", "/v1/jobs", json={"capture": "studio"}).json()["id"]

    async def scenario() -> None:
        async with contextlib.AsyncExitStack() as stack:
            serving = contextlib.AsyncExitStack()
            address = await serving.enter_async_context(running(server.app))
            socket = await stack.enter_async_context(websockets.connect(f"ws://{address}/v1/scenes/studio/stream"))
            await socket.send(encode(Hello(1, 0)))
            await receive(socket)
            client = await stack.enter_async_context(httpx.AsyncClient(base_url=f"http://{address}"))
            events = await stack.enter_async_context(client.stream("GET", f"/v1/jobs/{job_id}/events"))
            lines = events.aiter_lines()
            assert await anext(lines) == "event: job"
            await serving.aclose()
            await asyncio.wait_for(socket.wait_closed(), 30)
            assert socket.close_code == 1012
            async for _ in lines:  # the event stream ends properly, not by a reset
                pass

    asyncio.run(scenario())


def test_a_request_that_outlasts_the_shutdown_is_to_be_sent_again(server: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_server, "SHUTDOWN_SECONDS", 0)
    asked, released = threading.Event(), threading.Event()

    def hang() -> list[SceneEntry]:
        asked.set()
        released.wait()
        return []

    server.artifacts.list_scenes = hang

    async def scenario() -> httpx.Response:
        async with httpx.AsyncClient(timeout=None) as client:
            async with running(server.app) as address:
                answer = asyncio.create_task(client.get(f"http://{address}/v1/scenes"))
                await asyncio.to_thread(asked.wait)
            try:
                return await answer
            finally:
                released.set()

    answer = asyncio.run(scenario())
    assert (answer.status_code, answer.json()["code"]) == (503, "server-busy")
    assert int(answer.headers["retry-after"]) > 0


def test_events_follow_a_job_to_its_end(server: Any) -> None:
    job_id = server.request("POST", "/v1/jobs", json={"capture": "studio"}).json()["id"]

    async def scenario() -> list[str]:
        states = []
        async with (
            running(server.app) as address,
            httpx.AsyncClient(base_url=f"http://{address}") as client,
            client.stream("GET", f"/v1/jobs/{job_id}/events") as events,
        ):
            async for line in events.aiter_lines():
                if line.startswith("data: "):
                    states.append(json.loads(line.removeprefix("data: "))["state"])
                    following = {"queued": JobState.RUNNING, "running": JobState.SUCCEEDED}.get(states[-1])
                    if following is not None:
                        server.jobs.change(job_id, state=following)
        return states

    assert asyncio.run(scenario()) == ["queued", "running", "succeeded"]


def test_address_that_is_taken_is_bad_input() -> None:
    with bind("127.0.0.1", 0) as listener:
        listener.listen()
        port = listener.getsockname()[1]
        with pytest.raises(InputError, match=f"127.0.0.1:{port}: cannot listen"):
            bind("127.0.0.1", port)


def test_port_out_of_range_is_bad_input() -> None:
    with pytest.raises(InputError, match="70000 is not a port"):
        bind("127.0.0.1", 70_000)


def test_what_is_there_when_a_server_begins_is_not_looked_through_again(monkeypatch: pytest.MonkeyPatch) -> None:
    frozen: list[Any] = []
    monkeypatch.setattr(gc, "collect", lambda: frozen.append("collect"))
    monkeypatch.setattr(gc, "freeze", lambda: frozen.append("freeze"))
    monkeypatch.setattr(gc, "set_threshold", lambda *counts: frozen.append(math.prod(counts)))
    spare_collector()
    assert frozen == ["collect", "freeze", 1_000_000]  # garbage of that moment would stay for good
