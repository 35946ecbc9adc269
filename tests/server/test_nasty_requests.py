"""Requests that no decent client sends: each gets an answer of the client's fault, and the log stays empty."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import queue
import socket
import threading
from collections.abc import Iterator, MutableMapping, Sequence
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote

import pytest
from fastapi import FastAPI
from hypothesis import given, settings
from hypothesis import strategies as st

from jobs.home.home import Home
from server.app import create_app
from server.captures.capture_folders import CaptureFolders
from tests.server.conftest import running_server


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FastAPI]:
    """The application on a real queue and a real store, with a built viewer."""
    folder = tmp_path_factory.mktemp("nasty")
    (folder / "viewer" / "assets").mkdir(parents=True)
    for name in ("index.html", "view.html", "assets/main-1a2b.js"):
        (folder / "viewer" / name).write_text(name)
    captures = CaptureFolders((folder.resolve(),))
    app = create_app(Home.at(folder / "home"), captures=captures, viewer=folder / "viewer")
    yield app
    app.state.service.jobs.close()


class Faults(logging.Handler):
    """A handler that keeps records worse than a warning."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.seen: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.seen.append(record.getMessage())


@pytest.fixture(scope="module")
def wire(app: FastAPI) -> Iterator[tuple[tuple[str, int], Faults]]:
    """The application behind a socket: its address, and its log."""
    faults, news, stop = Faults(), queue.SimpleQueue[str](), threading.Event()

    async def serve() -> None:
        async with running_server(app) as (_, address):
            news.put(address)
            while not stop.is_set():
                await asyncio.sleep(0.05)

    logging.getLogger().addHandler(faults)
    thread = threading.Thread(target=lambda: asyncio.run(serve()))
    thread.start()
    host, _, port = news.get(timeout=60).partition(":")
    yield (host, int(port)), faults
    stop.set()
    thread.join()
    logging.getLogger().removeHandler(faults)


@dataclass
class Answer:
    """The messages that the application has sent."""

    status: int = 0
    headers: dict[str, str] = field(default_factory=dict)
    body: bytes = b""


def ask(
    app: FastAPI, method: str, target: bytes, headers: Sequence[tuple[bytes, bytes]] = (), body: bytes = b""
) -> Answer:
    """Send one request as uvicorn hands it on, past every check of a client's library."""
    path, _, query = target.partition(b"?")
    scope = {
        "type": "http",
        "asgi": {"version": "3.0", "spec_version": "2.3"},
        "http_version": "1.1",
        "scheme": "http",
        "server": ("127.0.0.1", 80),
        "client": ("127.0.0.1", 1234),
        "method": method,
        "root_path": "",
        "state": {},
        "path": unquote(path.decode("ascii")),
        "raw_path": path,
        "query_string": query,
        "headers": [(b"host", b"localhost"), *((name.lower(), value) for name, value in headers)],
    }
    messages = [{"type": "http.request", "body": body, "more_body": False}]
    answer = Answer()

    async def receive() -> dict[str, Any]:
        return messages.pop() if messages else {"type": "http.disconnect"}

    async def send(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            answer.status = message["status"]
            answer.headers = {name.decode(): value.decode("latin-1") for name, value in message["headers"]}
        else:
            answer.body += message["body"]

    asyncio.run(app(scope, receive, send))
    return answer


def assert_answered(answer: Answer) -> None:
    assert 200 <= answer.status < 500, answer
    if answer.status >= 400:
        if answer.headers["content-type"] == "application/problem+json":
            assert json.loads(answer.body)["status"] == answer.status
        else:
            assert answer.headers["content-type"].startswith("text/html")


LONG = b"9" * 5000
CHUNK_PATH = b"/v1/chunks/" + b"0" * 64


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        (b"/" + b"a" * 300, {}),
        (b"/" + b"a/" * 3000, {}),
        (b"/view/" + b"a" * 300, {}),
        (b"/assets/%00", {}),
        (b"/assets/%2e%2e%2f%2e%2e%2fetc%2fpasswd", {}),
        (b"/v1/jobs/%00", {}),
        (b"/v1/jobs/" + b"a" * 5000, {}),
        (b"/v1/jobs/%ed%a0%80", {}),
        (b"/v1/jobs/%00/events", {}),
        (b"/v1/scenes/%00", {}),
        (b"/v1/scenes/" + b"a" * 5000 + b"/manifest", {}),
        (b"/v1/scenes/..%2f..%2fx/thumbnail", {}),
        (b"/v1/chunks/%ff%fe", {}),
        (b"/%ed%a0%80", {}),
        (b"/?" + b"%ed%a0%80" * 100, {}),
        (CHUNK_PATH, {b"Range": b"bytes=0-" + LONG}),
        (b"/", {b"Accept-Encoding": b"gzip;q=" + LONG}),
        (b"/", {b"Accept-Encoding": b"," * 5000}),
        (b"/", {b"If-None-Match": b'"' * 5000}),
        (b"/", {b"Accept": b"\xff\xfe"}),
        (b"/v1/jobs", {b"Origin": b"http://[", b"Content-Type": b"application/json"}),
        (b"/v1/jobs", {b"Content-Type": b"application/json;" * 500}),
    ],
)
@pytest.mark.parametrize("method", ["GET", "HEAD", "POST", "OPTIONS", "DELETE"])
def test_what_broke_servers_before(app: FastAPI, method: str, path: bytes, headers: dict[bytes, bytes]) -> None:
    assert_answered(ask(app, method, path, [*headers.items()]))


BODIES = [
    b"",
    b"null",
    b"\xff",
    b"\xef\xbb\xbf{}",
    b'{"capture":"\\ud800"}',
    b'{"capture":"x","title":"\\ud800"}',
    b'{"capture":"x","\\ud800":1}',
    b'{"capture":"x","preset":"\\ud800"}',
    b'{"capture":"x","hold_out":["\\ud800"]}',
    b'{"capture":"x","config":{"\\ud800":1}}',
    b'{"capture":"\\u0000"}',
    b'{"capture":"x","config":{"iterations":NaN}}',
    b'{"capture":"x","config":{"a":' + b"[" * 30000 + b"]" * 30000 + b"}}",
    b'{"capture":"x","config":{"iterations":' + LONG + b"}}",
    b"[" * 60000,
    b'"' + b"a" * 70000 + b'"',
]


@pytest.mark.parametrize("body", BODIES, ids=lambda body: body[:40].decode(errors="replace"))
def test_bodies_that_broke_servers_before(app: FastAPI, body: bytes) -> None:
    assert_answered(ask(app, "POST", b"/v1/jobs", [(b"Content-Type", b"application/json")], body))


PARTS = st.sampled_from(
    [
        b"/",
        b"v1",
        b"jobs",
        b"scenes",
        b"chunks",
        b"events",
        b"manifest",
        b"thumbnail",
        b"stream",
        b"cancel",
        b"view",
        b"assets",
        b"main-1a2b.js",
        b"..",
        b".",
        b"%00",
        b"%2f",
        b"%2e%2e",
        b"%ff",
        b"%ed%a0%80",
        b"%",
        b"~",
        b"?",
        b"#",
        b"0" * 64,
        b"a" * 300,
        b"index.html",
        b"\\",
        b"%0d%0a",
        b"*",
        b"[",
        b"{x}",
    ]
)
HEADERS = st.lists(
    st.tuples(
        st.sampled_from(
            [
                b"Range",
                b"If-Range",
                b"If-None-Match",
                b"Accept",
                b"Accept-Encoding",
                b"Content-Type",
                b"Origin",
                b"Last-Event-ID",
                b"X-Forwarded-For",
                b"Access-Control-Request-Method",
                b"Content-Encoding",
                b"Host",
            ]
        ),
        st.one_of(
            st.binary(max_size=30).filter(lambda value: not set(value) & set(b"\r\n\0")),
            st.sampled_from([b"*", b"bytes=0-", b"bytes=-1", b"gzip", b"text/html", b"application/json", LONG]),
        ),
    ),
    max_size=4,
)


@settings(max_examples=300, deadline=None)
@given(
    method=st.sampled_from(["GET", "HEAD", "POST", "PUT", "OPTIONS", "TRACE"]),
    parts=st.lists(PARTS, max_size=6),
    headers=HEADERS,
    body=st.one_of(st.just(b""), st.sampled_from(BODIES), st.binary(max_size=50)),
)
def test_no_request_is_the_servers_fault(
    app: FastAPI, method: str, parts: list[bytes], headers: list[tuple[bytes, bytes]], body: bytes
) -> None:
    assert_answered(ask(app, method, b"/" + b"/".join(parts), headers, body))


@settings(max_examples=300, deadline=None)
@given(
    start=st.sampled_from(
        [
            b"GET / HTTP/1.1",
            b"OPTIONS * HTTP/1.1",
            b"CONNECT localhost:80 HTTP/1.1",
            b"GET http://[/ HTTP/1.1",
            b"get /",
            b"GET  / HTTP/1.1",
            b"GET / HTTP/9.9",
            b"GET /\xff HTTP/1.1",
            b"PRI * HTTP/2.0",
            b"\x16\x03\x01",
            b"",
            b"POST /v1/jobs HTTP/1.1",
            b"GET /v1/scenes/x/stream HTTP/1.1",
        ]
    ),
    headers=st.lists(
        st.sampled_from(
            [
                b"Host: localhost",
                b"Host: evil.example",
                b"Host:",
                b"Content-Length: 5",
                b"Content-Length: -1",
                b"Content-Length: 5, 5",
                b"Transfer-Encoding: chunked",
                b"Transfer-Encoding: gzip",
                b"Expect: 100-continue",
                b"Connection: upgrade",
                b"Upgrade: websocket",
                b"Upgrade: h2c",
                b"Sec-WebSocket-Version: 13",
                b"Sec-WebSocket-Key: x",
                b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
                b"Connection: close",
                b": x",
                b"X: " + b"x" * 20000,
                b"Content-Type: application/json",
            ]
        ),
        max_size=6,
    ),
    body=st.sampled_from([b"", b"{}", b"5\r\nhello\r\n0\r\n\r\n", b"zz\r\n", b"\0" * 100, b"GET / HTTP/1.1\r\n\r\n"]),
)
def test_nothing_on_the_wire_is_the_servers_fault(
    wire: tuple[tuple[str, int], Faults], start: bytes, headers: list[bytes], body: bytes
) -> None:
    address, faults = wire
    with socket.create_connection(address, timeout=60) as client:
        client.sendall(b"\r\n".join([start, *headers, b"", body]))
        client.shutdown(socket.SHUT_WR)
        answer = b""
        with contextlib.suppress(ConnectionResetError):
            while data := client.recv(65536):
                answer += data
    assert not answer.startswith(b"HTTP/1.1 5"), answer
    assert faults.seen == []
