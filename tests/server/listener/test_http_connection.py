"""Connections of a real server, held by clients that do not behave."""

from __future__ import annotations

import asyncio
import base64
import contextlib
import dataclasses
import hashlib
import json
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any, cast

import httpx
import pytest
import websockets

from server.listener import http_connection
from server.listener.connection_limits import ConnectionLimits, OpenConnections
from server.listener.http_connection import WebSocketConnection
from server.listener.http_server import HttpServer
from tests.conftest import REPOSITORY
from tests.server.conftest import running_server

PATIENT = ConnectionLimits(100, 100, batch=100, head_seconds=600, body_seconds=600, idle_seconds=600, stall_seconds=600)


class Client:
    """One plain TCP connection."""

    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.reader, self.writer = reader, writer

    async def send(self, text: str) -> None:
        self.writer.write(text.encode())
        await self.writer.drain()

    async def answer(self) -> tuple[int, bytes]:
        """Read one answer that has a length."""
        head = (await asyncio.wait_for(self.reader.readuntil(b"\r\n\r\n"), 60)).decode().lower()
        length = int(head.partition("content-length: ")[2].partition("\r\n")[0])
        return int(head.split()[1]), await self.reader.readexactly(length)

    async def rest(self) -> bytes:
        """Return the bytes until the server closes the connection."""
        with contextlib.suppress(ConnectionResetError):
            return await asyncio.wait_for(self.reader.read(), 60)
        return b""


@contextlib.asynccontextmanager
async def connections(server: Any, **limits: float) -> AsyncIterator[tuple[HttpServer, Any]]:
    """Serve, patiently but for the given limits; yield the server and a function that connects to it."""
    async with contextlib.AsyncExitStack() as stack:
        http, address = await stack.enter_async_context(
            running_server(server.app, limits=dataclasses.replace(PATIENT, **limits))
        )
        host, _, port = address.partition(":")

        async def connect() -> Client:
            client = Client(*await asyncio.open_connection(host, int(port)))
            stack.callback(client.writer.close)
            return client

        yield http, connect


def set_limits(http: HttpServer, **limits: float) -> None:
    """Change the limits of later connections."""
    state = cast(OpenConnections, http.server_state)
    state.limits = dataclasses.replace(state.limits, **limits)


HEAD = "GET /v1/health HTTP/1.1\r\nHost: localhost\r\n"
POST = "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: 100\r\n\r\n"


def test_answers_leave_at_once(server: Any) -> None:
    async def scenario() -> None:
        async with running_server(server.app) as (http, address), httpx.AsyncClient() as client:
            await client.get(f"http://{address}/v1/health")
            (connection,) = http.server_state.connections
            accepted = connection.transport.get_extra_info("socket")  # type: ignore[union-attr]
            assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) != 0

    asyncio.run(scenario())


def test_connection_that_asks_nothing_is_closed(server: Any) -> None:
    async def scenario() -> None:
        async with connections(server, head_seconds=0.1) as (_, connect):
            assert await (await connect()).rest() == b""

    asyncio.run(scenario())


def test_request_that_comes_before_its_connection_is_ended_is_answered(
    server: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Connections that time out together are ended in turn."""

    async def scenario() -> None:
        ends: list[Callable[[], None]] = []
        monkeypatch.setattr(OpenConnections, "in_turn", lambda self, end: ends.append(end))
        async with connections(server, head_seconds=0.1) as (_, connect):
            client = await connect()
            while not ends:
                await asyncio.sleep(0.02)
            await client.send(f"{HEAD}\r\n")
            assert (await client.answer())[0] == 200
            ends[0]()
            await client.send(f"{HEAD}\r\n")
            assert (await client.answer())[0] == 200

    asyncio.run(scenario())


@pytest.mark.parametrize("before", [0, 1])
def test_headers_that_trickle_in_are_answered_with_408(server: Any, before: int) -> None:
    """On a new connection, and on one that has been used."""

    async def scenario() -> None:
        async with connections(server) as (http, connect):
            if not before:
                set_limits(http, head_seconds=0.3)
            client = await connect()
            for _ in range(before):
                await client.send(f"{HEAD}\r\n")
                assert (await client.answer())[0] == 200
            set_limits(http, head_seconds=0.3)
            answer = asyncio.create_task(client.rest())
            with contextlib.suppress(ConnectionError):
                await client.send(HEAD)
                while not answer.done():
                    await client.send("X")
                    await asyncio.sleep(0.02)
            assert await answer == b"" or (await answer).startswith(b"HTTP/1.1 408 ")

    asyncio.run(scenario())


def test_408_is_a_problem_document(server: Any) -> None:
    async def scenario() -> None:
        async with connections(server, head_seconds=0.1) as (_, connect):
            client = await connect()
            await client.send(HEAD)
            status, body = await client.answer()
            assert (status, json.loads(body)["code"]) == (408, "request-timeout")

    asyncio.run(scenario())


@pytest.mark.parametrize("sent", ["", "{"])
def test_body_that_does_not_come_is_answered_with_408(server: Any, sent: str, caplog: pytest.LogCaptureFixture) -> None:
    async def scenario() -> None:
        async with connections(server, body_seconds=0.1) as (_, connect):
            client = await connect()
            await client.send(POST + sent)
            status, body = await client.answer()
            assert (status, json.loads(body)["instance"]) == (408, "/v1/jobs")
            assert await client.rest() == b""

    asyncio.run(scenario())
    assert caplog.records == []


@pytest.mark.parametrize("fast", [True, False])
def test_a_long_body_has_time_as_long_as_it_comes_fast_enough(
    server: Any, fast: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The rate decides `fast`, not the clock; the body takes many of its spans of time."""
    monkeypatch.setattr(http_connection, "BODY_BYTES", 0 if fast else 1 << 30)
    size = 1 << 20
    upload = server.request("POST", "/v1/uploads", json={"name": "a", "files": 1, "bytes": size}).json()["id"]
    metadata = "path YQ==,sha256 " + base64.b64encode(hashlib.sha256(bytes(size)).hexdigest().encode()).decode()
    head = (
        f"POST /v1/uploads/{upload}/files HTTP/1.1\r\nHost: localhost\r\nTus-Resumable: 1.0.0\r\n"
        f"Upload-Length: {size}\r\nUpload-Metadata: {metadata}\r\nContent-Length: {size}\r\n"
        "Content-Type: application/offset+octet-stream\r\n\r\n"
    )

    async def scenario() -> int:
        async with connections(server, body_seconds=0.3) as (_, connect):
            client = await connect()
            await client.send(head)
            answer = asyncio.create_task(client.answer())
            with contextlib.suppress(ConnectionError):
                for _ in range(64):
                    await client.send("\0" * (size // 64))
                    await asyncio.sleep(0.02)
            return (await answer)[0]

    try:
        assert asyncio.run(scenario()) == (201 if fast else 408)
    finally:
        server.app.state.service.uploads.close()


@pytest.mark.parametrize(
    ("sent", "status"),
    [
        (POST + "{", 408),
        (f"{POST[:-2]}Transfer-Encoding: chunked\r\n\r\n", 400),
        (f"GET /{'x' * 10_000}", 414),
    ],
)
def test_a_refusal_resets_no_client_that_is_still_sending(
    server: Any, sent: str, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A reset may reach a client before it has read the answer (RFC 9112, 9.6)."""
    monkeypatch.setattr(http_connection, "LINGER_SECONDS", 60.0)

    async def scenario() -> None:
        async with connections(server, body_seconds=0.1) as (_, connect):
            client = await connect()
            await client.send(sent)
            assert (await client.answer())[0] == status
            for _ in range(3):
                await client.send("x" * 1000)
                await asyncio.sleep(0.02)
            assert await client.reader.read() == b""

    asyncio.run(scenario())


def test_rest_of_a_body_that_was_refused_is_not_waited_for(server: Any) -> None:
    async def scenario() -> None:
        async with connections(server, body_seconds=0.1) as (_, connect):
            client = await connect()
            await client.send(POST.replace("application/json", "text/plain"))
            assert (await client.answer())[0] in (415, 408)  # 408 if the machine was too busy to read on in time
            assert await client.rest() == b""

    asyncio.run(scenario())


def test_idle_connection_is_closed_in_the_end(server: Any) -> None:
    async def scenario() -> None:
        async with connections(server, idle_seconds=0.1) as (_, connect):
            client = await connect()
            await client.send(f"{HEAD}\r\n")
            assert (await client.answer())[0] == 200
            assert await client.rest() == b""

    asyncio.run(scenario())


def test_client_that_takes_nothing_of_its_answer_is_cut_off(server: Any) -> None:
    chunk = server.artifacts.add_chunk(bytes(8 << 20))

    async def scenario() -> None:
        async with connections(server, stall_seconds=0.1) as (http, connect):
            client = await connect()
            client.writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            client.writer.transport.pause_reading()
            for _ in range(4):
                await client.send(f"GET /v1/chunks/{chunk} HTTP/1.1\r\nHost: localhost\r\n\r\n")
            while not http.server_state.total_requests:
                await asyncio.sleep(0.01)
            while http.server_state.connections:
                await asyncio.sleep(0.01)

    asyncio.run(asyncio.wait_for(scenario(), 60))


def test_websocket_leaves_the_time_outs_of_http_behind(server: Any, manifest: bytes) -> None:
    server.artifacts.manifests["studio"] = manifest

    async def scenario() -> None:
        async with (
            running_server(server.app, limits=PATIENT) as (http, address),
            websockets.connect(f"ws://{address}/v1/scenes/studio/stream"),
        ):
            (connection,) = http.server_state.connections
            assert isinstance(connection, WebSocketConnection)
            began = connection.began_as
            assert began is not None
            assert [began._request_timer, began._drain_timer, began.timeout_keep_alive_task] == [None] * 3

    asyncio.run(scenario())


def test_connection_that_waits_makes_room_for_one_that_asks(server: Any) -> None:
    async def scenario() -> None:
        async with connections(server, per_address=3) as (http, connect):
            idle = [await connect() for _ in range(3)]
            await idle[2].send(HEAD)
            asking = await connect()
            await asking.send(f"{HEAD}\r\n")
            assert (await asking.answer())[0] == 200
            assert await idle[0].rest() == b""  # the one that has waited the longest
            assert len(http.server_state.connections) == 3
            await idle[1].send(f"{HEAD}\r\n")
            assert (await idle[1].answer())[0] == 200

    asyncio.run(scenario())


@pytest.mark.parametrize("limit", ["per_address", "total"])
def test_connection_is_refused_where_all_are_in_use(server: Any, manifest: bytes, limit: str) -> None:
    server.artifacts.manifests["studio"] = manifest

    async def scenario() -> None:
        limits = dataclasses.replace(PATIENT, **{limit: 2})
        async with running_server(server.app, limits=limits) as (_, address):
            url = f"ws://{address}/v1/scenes/studio/stream"
            async with websockets.connect(url):
                async with websockets.connect(url):
                    with pytest.raises(websockets.InvalidStatus) as caught:
                        await websockets.connect(url)
                    assert caught.value.response.status_code == 503
                    assert caught.value.response.body is not None
                    assert json.loads(caught.value.response.body)["code"] == "too-many-connections"
                async with websockets.connect(url):  # the place of the one that has ended
                    pass

    asyncio.run(scenario())


def test_nothing_is_remembered_of_connections_that_have_ended(server: Any, manifest: bytes) -> None:
    """Whether they were closed by the client, made room, or were refused."""
    server.artifacts.manifests["studio"] = manifest

    async def scenario() -> None:
        limits = dataclasses.replace(PATIENT, total=1, per_address=1)
        async with running_server(server.app, limits=limits) as (http, address):
            host, _, port = address.partition(":")
            clients = [Client(*await asyncio.open_connection(host, int(port))) for _ in range(3)]
            await clients[2].send(f"{HEAD}Connection: close\r\n\r\n")
            assert (await clients[2].answer())[0] == 200
            for client in clients:
                assert await client.rest() == b""
                client.writer.close()
            async with websockets.connect(f"ws://{address}/v1/scenes/studio/stream"):
                for source in ("127.0.0.1", "127.0.0.2"):
                    refused = Client(*await asyncio.open_connection(host, int(port), local_addr=(source, 0)))
                    assert (await refused.answer())[0] == 503
                    refused.writer.close()
            while http.server_state.connections:
                await asyncio.sleep(0.01)
            state = cast(OpenConnections, http.server_state)
            assert [len(s) for s in (state._places, state._of_address, state._waiting, state._waiting_of)] == [0] * 4

    asyncio.run(scenario())


def test_what_is_not_http_is_answered_with_a_problem_document(server: Any) -> None:
    async def scenario() -> None:
        async with connections(server) as (_, connect):
            client = await connect()
            await client.send("HELO mail.example\r\n\r\n")
            status, body = await client.answer()
            assert (status, json.loads(body)["code"]) == (400, "bad-request")
            assert await client.rest() == b""

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("request_text", "status", "why"),
    [
        (f"{POST[:-2]}Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400, "may have only one"),
        (HEAD.replace("\r", "") + "\n", 400, "CR LF"),
        (f"{HEAD}X: 1\r\n folded\r\n\r\n", 400, "next line"),
        (HEAD + "X: 1\r\n" * 10_000 + "\r\n", 431, "128 header lines"),
        (f"{HEAD}X: {'x' * 70_000}\r\n\r\n", 431, "64 KiB"),
        (HEAD.replace("health", "x" * 9000) + "\r\n", 414, "8 KiB"),
    ],
)
def test_request_that_a_proxy_could_see_otherwise_is_refused_and_its_connection_ends(
    server: Any, request_text: str, status: int, why: str
) -> None:
    async def scenario() -> None:
        async with connections(server) as (_, connect):
            client = await connect()
            await client.send(f"{HEAD}\r\n")
            assert (await client.answer())[0] == 200
            await client.send(f"{request_text}{HEAD}\r\n")
            found, body = await client.answer()
            assert (found, json.loads(body)["code"]) == (status, "bad-request")
            assert why in json.loads(body)["detail"]
            assert await client.rest() == b""  # no answer to later requests

    asyncio.run(scenario())


def test_client_that_leaves_in_the_middle_of_a_body_is_no_fault(server: Any, caplog: pytest.LogCaptureFixture) -> None:
    async def scenario() -> None:
        async with connections(server) as (http, connect):
            client = await connect()
            await client.send(f"{POST}{{")
            while not http.server_state.tasks:
                await asyncio.sleep(0.01)
            client.writer.close()
            while http.server_state.connections or http.server_state.tasks:
                await asyncio.sleep(0.01)

    asyncio.run(asyncio.wait_for(scenario(), 60))
    assert caplog.records == []


TOO_FEW_FILES = """
import asyncio, resource, sys
from pathlib import Path
from jobs.home.home import Home
from server.app import create_app
from server.listener.connection_limits import ConnectionLimits
from server.http.log_lines import configure_log
from server.listener.http_server import HttpServer, bind

configure_log()
resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
listener = bind("127.0.0.1", 0)
server = HttpServer(
    create_app(Home.at(Path(sys.argv[1]))),
    limits=ConnectionLimits(1000, 1000, batch=1000),
    on_ready=lambda: print(listener.getsockname()[1], flush=True),
)
server.run([listener])
"""


def test_lack_of_files_is_told_in_few_words(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", TOO_FEW_FILES, str(tmp_path)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=REPOSITORY,
    )
    try:
        assert process.stdout is not None
        assert process.stderr is not None
        port = int(process.stdout.readline())
        with contextlib.ExitStack() as stack:
            for _ in range(100):
                stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=60))
            first = process.stderr.readline()
            assert "out of system resource" in first
        assert httpx.get(f"http://127.0.0.1:{port}/v1/health", timeout=60).status_code == 200
    finally:
        process.terminate()
        _, errors = process.communicate(timeout=60)
    assert len(errors.splitlines()) < 40
