from __future__ import annotations

import asyncio
import http.server
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from server.bench.bench_scene import made_up_scene
from server.client.received_scene import StreamRefusedError
from server.client.scene_files import AwayError, SceneFiles

SCENE = made_up_scene(2, static_bytes=20_000, slice_bytes=3_000)
PROBLEM = b'{"code": "%s", "detail": "the server says so"}'

Answer = tuple[int, bytes, dict[str, str]]


@contextmanager
def answering(answer: Callable[[str, dict[str, str]], Answer]) -> Iterator[str]:
    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            status, body, headers = answer(self.path, {name.lower(): value for name, value in self.headers.items()})
            self.send_response(status)
            for name, value in (headers | {"Content-Length": str(len(body))}).items():
                self.send_header(name, value)
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


def test_files_lie_beside_the_stream_below_any_path() -> None:
    files = SceneFiles.beside("wss://h/my%20scenes/v1/scenes/a/stream?link=x.y", "hgs_key")
    assert files.first == "https://h/my%20scenes/v1/scenes/a/index.hgs"
    assert (files.whole, files.opens) == ("https://h/my%20scenes/v1/scenes/a/manifest", "?link=x.y")


@pytest.mark.parametrize("url", ["http://h/a/", "http://h/a/manifest.json"])
def test_a_folder_stands_for_its_manifest(url: str) -> None:
    assert SceneFiles.at(url).first == "http://h/a/manifest.json"


def test_key_and_link_are_sent_with_every_request_and_a_tag_with_the_second() -> None:
    asked: list[tuple[str, str | None, str | None]] = []

    def answer(path: str, headers: dict[str, str]) -> Answer:
        asked.append((path, headers.get("authorization"), headers.get("if-none-match")))
        return (304, b"", {}) if "if-none-match" in headers else (200, SCENE.document, {"ETag": '"1"'})

    with answering(answer) as host:
        files = SceneFiles.beside(f"ws{host[4:]}/v1/scenes/a/stream?link=x", "hgs_key")

        async def twice() -> None:
            assert await files.manifest() is not None
            assert await files.manifest() is None
            await files.chunk("00")

        asyncio.run(twice())
    assert asked == [
        ("/v1/scenes/a/index.hgs?link=x", "Bearer hgs_key", None),
        ("/v1/scenes/a/index.hgs?link=x", "Bearer hgs_key", '"1"'),
        ("/v1/scenes/a/chunks/00?link=x", "Bearer hgs_key", None),
    ]


def test_a_key_is_not_sent_to_where_a_server_redirects() -> None:
    asked: list[str | None] = []

    def elsewhere(path: str, headers: dict[str, str]) -> Answer:
        asked.append(headers.get("authorization"))
        return 200, SCENE.document, {}

    with answering(elsewhere) as other, answering(lambda *_: (302, b"", {"Location": f"{other}/a"})) as host:
        files = SceneFiles.beside(f"ws{host[4:]}/v1/scenes/a/stream", "hgs_key")
        assert asyncio.run(files.manifest()) is not None
    assert asked == [None]


@pytest.mark.parametrize(
    ("status", "body", "error"),
    [
        (401, PROBLEM % b"key-needed", StreamRefusedError),
        (403, b"a proxy's page", StreamRefusedError),
        (404, PROBLEM % b"scene-not-found", StreamRefusedError),
        (421, PROBLEM % b"host-not-allowed", StreamRefusedError),
        (404, b"a proxy's page", AwayError),
        (429, PROBLEM % b"later", AwayError),
        (502, b"a proxy's page", AwayError),
        (503, PROBLEM % b"server-busy", AwayError),
        (200, b"<!doctype html>", AwayError),
        (200, b"[1]", AwayError),
        (200, b"\x1f\x8bnone", AwayError),
    ],
)
def test_what_another_try_would_get_too_is_told_from_what_it_may_not(
    status: int, body: bytes, error: type[Exception]
) -> None:
    with answering(lambda *_: (status, body, {})) as host, pytest.raises(error) as caught:
        asyncio.run(SceneFiles.beside(f"ws{host[4:]}/v1/scenes/a/stream").manifest())
    if body.startswith(b"{") and error is StreamRefusedError:
        assert "the server says so" in str(caught.value)


def test_a_server_that_cannot_be_reached_is_away() -> None:
    with answering(lambda *_: (200, b"", {})) as host:
        pass
    with pytest.raises(AwayError):
        asyncio.run(SceneFiles.at(f"{host}/a/").manifest())


def test_a_chunk_that_a_folder_lacks_is_none() -> None:
    with answering(lambda *_: (404, b"", {})) as host:
        assert asyncio.run(SceneFiles.at(f"{host}/a/").chunk("00")) is None
