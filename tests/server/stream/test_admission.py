"""Streams that are let in, turned away, and ended."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest
import websockets
from websockets.asyncio.client import ClientConnection
from websockets.exceptions import InvalidStatus

from server.app import create_app
from server.protocol.messages import Hello, encode
from server.stream import admission as open_streams
from server.stream.admission import OpenStreams
from tests.server.conftest import Server, running_server
from tests.server.listener.test_http_server import receive


def test_a_server_is_full_at_its_limit_when_it_is_late_and_when_it_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(open_streams, "LATE_SECONDS", 1.0)
    lag = [0.0]
    streams = OpenStreams(1, lambda: lag[0])
    assert not streams.full
    leave = streams.join()
    assert streams.full
    streams.part(leave)
    assert not streams.full
    lag[0] = 1.1
    assert streams.full
    lag[0] = 0.0
    asyncio.run(streams.drain(0.0))
    assert streams.full


def test_streams_are_told_to_leave_one_after_the_other(monkeypatch: pytest.MonkeyPatch) -> None:
    streams = OpenStreams()
    events = [streams.join() for _ in range(4)]
    told: list[int] = []

    async def sleep(seconds: float) -> None:
        assert seconds == 2.0
        told.append(sum(event.is_set() for event in events))

    monkeypatch.setattr(open_streams.asyncio, "sleep", sleep)
    asyncio.run(streams.drain(8.0))
    assert told == [0, 1, 2, 3]
    assert all(event.is_set() for event in events)


def conversing(server: Server, manifest: bytes, limit: int, talk: Callable[[str, Server], Awaitable[None]]) -> None:
    server.artifacts.manifests["studio"] = manifest
    app = create_app(server.home, job_client=server.jobs, artifacts=server.artifacts, max_streams=limit)
    limited = Server(app, server.jobs, server.artifacts, server.captures, server.home)

    async def run() -> None:
        async with running_server(app) as (_, address):
            await talk(f"ws://{address}/v1/scenes/studio/stream", limited)

    asyncio.run(run())


async def greeted(socket: ClientConnection) -> None:
    await socket.send(encode(Hello(1, 4144)))
    await receive(socket)


def test_one_too_many_is_told_to_come_again(server: Server, manifest: bytes) -> None:
    async def talk(url: str, limited: Server) -> None:
        async with websockets.connect(url) as socket:
            await greeted(socket)
            with pytest.raises(InvalidStatus) as refused:
                await websockets.connect(url).__aenter__()
            response = refused.value.response
            assert response.status_code == 503
            low, high = open_streams.RETRY_SECONDS
            assert low <= int(response.headers["Retry-After"]) <= high
            # Nor does watching over HTTP begin; who has begun goes on.
            index = "/v1/scenes/studio/index.hgs"
            assert (await asyncio.to_thread(limited.get, index)).status_code == 503
            assert (await asyncio.to_thread(limited.get, index, If_None_Match='"other"')).status_code == 200
            assert (await asyncio.to_thread(limited.get, "/v1/scenes/studio")).status_code == 200
        while len(limited.app.state.service.streams):
            await asyncio.sleep(0.02)
        async with websockets.connect(url) as socket:
            await greeted(socket)

    conversing(server, manifest, 1, talk)


def test_a_stream_that_is_told_to_leave_ends_with_1012(server: Server, manifest: bytes) -> None:
    async def talk(url: str, limited: Server) -> None:
        async with websockets.connect(url) as socket:
            await greeted(socket)
            await limited.app.state.service.streams.drain(0.0)
            await socket.wait_closed()
            assert socket.close_code == 1012
        ready = await asyncio.to_thread(limited.get, "/readyz")
        assert (ready.status_code, ready.json()["stopping"]) == (503, True)

    conversing(server, manifest, 5, talk)
