from __future__ import annotations

from typing import Any

import pytest

DATA = bytes(range(256)) * 4


@pytest.fixture
def path(server: Any) -> str:
    return f"/v1/chunks/{server.artifacts.add_chunk(DATA)}"


def test_chunk_is_immutable_and_named_by_its_hash(server: Any, path: str) -> None:
    response = server.get(path)
    assert (response.status_code, response.content) == (200, DATA)
    assert response.headers["content-type"] == "application/octet-stream"
    assert response.headers["cache-control"] == "public, max-age=31536000, immutable"
    assert response.headers["accept-ranges"] == "bytes"
    assert response.headers["etag"] == f'"{path.rpartition("/")[2]}"'


def test_head_gives_the_headers(server: Any, path: str) -> None:
    response = server.request("HEAD", path)
    assert (response.status_code, response.headers["content-length"]) == (200, str(len(DATA)))


def test_second_request_does_not_read_the_store(server: Any, path: str) -> None:
    server.get(path)
    server.get(path)
    assert server.artifacts.reads == 1


@pytest.mark.parametrize("name", ["0" * 64, "short", "..%2f..%2fetc%2fpasswd"])
def test_unknown_chunks_are_404(server: Any, name: str) -> None:
    response = server.get(f"/v1/chunks/{name}")
    assert response.status_code == 404
    assert response.headers["content-type"] == "application/problem+json"


def test_damaged_chunk_is_never_served(server: Any, path: str) -> None:
    server.artifacts.chunks[path.rpartition("/")[2]] = b"other bytes"
    response = server.get(path)
    assert (response.status_code, response.json()["code"]) == (500, "chunk-damaged")
    assert path.rpartition("/")[2] in response.json()["detail"]


def test_chunk_that_the_client_has_is_304(server: Any, path: str) -> None:
    etag = server.get(path).headers["etag"]
    assert server.get(path, If_None_Match=etag).status_code == 304


def test_part_of_a_chunk_can_be_asked_for(server: Any, path: str) -> None:
    response = server.get(path, Range="bytes=1000-")
    assert (response.status_code, response.content) == (206, DATA[1000:])
