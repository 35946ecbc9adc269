from __future__ import annotations

import http.server
import socket
import threading
from collections.abc import Iterator

import pytest

from hgs_core.base.errors import InputError
from hgs_core.base.progress import StageStopped
from server.cli import server_client
from server.cli.server_client import LostConnectionError, RefusedError, ServerClient

ANSWERS: list[tuple[int, bytes]] = []
"""The next answers of the server; a status of 0 ends the connection without one."""

KEYS: list[str | None] = []
"""The `Authorization` headers that the server received."""


class Scripted(http.server.BaseHTTPRequestHandler):
    """A server that gives ordered answers, and then repeats the request."""

    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        self.do_POST()

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"] or 0))
        KEYS.append(self.headers["Authorization"])
        status, answer = ANSWERS.pop(0) if ANSWERS else (200, b'{"got": "%s %s"}' % (self.path.encode(), body))
        if status == 0:
            self.close_connection = True
            return
        self.send_response(status)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)

    def log_message(self, *_: object) -> None:
        pass


@pytest.fixture
def client(monkeypatch: pytest.MonkeyPatch) -> Iterator[ServerClient]:
    monkeypatch.setattr(server_client, "_LONGEST_WAIT", 0.0)
    ANSWERS.clear()
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Scripted) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,)).start()
        with ServerClient(f"http://127.0.0.1:{server.server_port}/base/") as made:
            yield made
        server.shutdown()


def test_what_may_pass_is_tried_again(client: ServerClient) -> None:
    ANSWERS.extend([(0, b""), (503, b'{"detail": "later"}'), (408, b"{}"), (502, b"<html>"), (200, b'{"a')])
    assert client.request("POST", "/x", body=b"b").value == {"got": "/base/x b"}
    assert ANSWERS == []
    ANSWERS.append((503, b'{"detail": "later"}'))
    with pytest.raises(LostConnectionError, match="later"):
        client.once("POST", "/x")


def test_a_key_of_the_environment_is_sent(client: ServerClient, monkeypatch: pytest.MonkeyPatch) -> None:
    client.request("POST", "/x")
    monkeypatch.setenv("HGS_KEY", "hgs_x")
    client.request("POST", "/x")
    assert KEYS[-2:] == [None, "Bearer hgs_x"]
    ANSWERS.append((401, b'{"detail": "a key is needed"}'))
    with pytest.raises(RefusedError, match="a key is needed; set HGS_KEY to a key of that server"):
        client.request("POST", "/x")


def test_a_refusal_is_told_in_the_servers_words(client: ServerClient) -> None:
    ANSWERS.append((413, b'{"detail": "too large; send less", "code": "upload-too-large"}'))
    with pytest.raises(RefusedError, match="too large; send less") as caught:
        client.request("POST", "/x")
    assert (caught.value.status, caught.value.code) == (413, "upload-too-large")


def test_patience_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server_client, "_LONGEST_WAIT", 0.0)
    client = ServerClient("http://127.0.0.1:1", patience=0.0)
    with pytest.raises(InputError, match=r"cannot be reached \(.*\); check the address, or give it longer"):
        client.request("GET", "/x")


def test_the_first_refusal_is_told_at_once(capsys: pytest.CaptureFixture[str]) -> None:
    client = ServerClient("http://127.0.0.1:1", patience=0.6)
    with pytest.raises(InputError, match="cannot be reached"):
        client.request("GET", "/x")
    assert (
        capsys.readouterr().err == "http://127.0.0.1:1: cannot be reached (Connection refused), trying again for 1 s\n"
    )


def test_a_server_that_answered_is_tried_for_longer(
    client: ServerClient, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    client.request("POST", "/x")
    monkeypatch.setattr(client, "_patience", 0.0)
    ANSWERS.extend([(0, b"")] * 5)
    client.request("POST", "/x")
    assert capsys.readouterr().err.endswith("trying again for 10 min\n")


def test_a_stopped_client_waits_for_nothing(client: ServerClient) -> None:
    client.stop()
    with pytest.raises(StageStopped):
        client.wait(0, LostConnectionError("away"))
    with pytest.raises(StageStopped):
        client.request("POST", "/x")


@pytest.mark.parametrize("answer", [(200, b"[]"), (200, b""), (200, b"null")])
def test_what_is_no_server_of_ours_is_called_so(client: ServerClient, answer: tuple[int, bytes]) -> None:
    ANSWERS.append(answer)
    with pytest.raises(InputError, match="does not answer as a server of HGS does"):
        client.request("GET", "/x")


def test_a_server_that_accepts_and_says_nothing_is_given_up() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        client = ServerClient(f"http://127.0.0.1:{listener.getsockname()[1]}", patience=0.0)
        with pytest.raises(InputError, match="cannot be reached"):
            client.request("GET", "/x")


def test_a_server_without_tls_is_told_from_one_that_is_away() -> None:
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Scripted) as server:
        threading.Thread(target=server.serve_forever, args=(0.01,)).start()
        try:
            with pytest.raises(InputError, match="cannot be reached safely"):
                ServerClient(f"https://127.0.0.1:{server.server_port}").request("GET", "/x")
        finally:
            server.shutdown()


@pytest.mark.parametrize(
    "url",
    [
        "host:8000",
        "ftp://host",
        "http://",
        "http://host:port",
        "http://host/?a",
        "http://[::1",
        "http://a..b",
        "http://a b",
        "http://host/é",
        "",
    ],
)
def test_what_is_no_address_is_refused(url: str) -> None:
    with pytest.raises(InputError, match="give it as in http://host:8000"):
        ServerClient(url)
