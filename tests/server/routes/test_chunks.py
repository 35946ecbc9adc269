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


@pytest.mark.parametrize("tag", ["{etag}", "W/{etag}", '"other", {etag}', "*"])
def test_known_chunk_is_304(server: Any, path: str, tag: str) -> None:
    etag = server.get(path).headers["etag"]
    response = server.get(path, If_None_Match=tag.format(etag=etag))
    assert (response.status_code, response.content) == (304, b"")
    assert response.headers["etag"] == etag


def test_other_tag_is_answered_with_the_body(server: Any, path: str) -> None:
    assert server.get(path, If_None_Match='"other"').status_code == 200


@pytest.mark.parametrize(
    ("asked", "first", "last"),
    [("bytes=0-0", 0, 0), ("bytes=10-19", 10, 19), ("bytes=1000-", 1000, 1023), ("bytes=-24", 1000, 1023),
     ("bytes=1000-9999", 1000, 1023), ("bytes=-9999", 0, 1023), ("Bytes=5-6", 5, 6)],
)  # fmt: skip
def test_range_is_206(server: Any, path: str, asked: str, first: int, last: int) -> None:
    response = server.get(path, Range=asked)
    assert (response.status_code, response.content) == (206, DATA[first : last + 1])
    assert response.headers["content-range"] == f"bytes {first}-{last}/1024"


@pytest.mark.parametrize("asked", ["bytes=0-1,4-5", "lines=1-2", "bytes=-", "bytes=9-3", "bytes", "bytes=a-b"])
def test_ranges_that_are_not_served_get_the_whole(server: Any, path: str, asked: str) -> None:
    response = server.get(path, Range=asked)
    assert (response.status_code, response.content) == (200, DATA)


@pytest.mark.parametrize("asked", ["bytes=1024-", "bytes=5000-6000", "bytes=-0"])
def test_range_behind_the_end_is_416(server: Any, path: str, asked: str) -> None:
    response = server.get(path, Range=asked)
    assert response.status_code == 416
    assert response.headers["content-range"] == "bytes */1024"
    assert response.json()["code"] == "range-not-satisfiable"


def test_if_range_with_another_tag_gets_the_whole(server: Any, path: str) -> None:
    assert server.get(path, Range="bytes=0-3", If_Range='"other"').status_code == 200
    etag = server.get(path).headers["etag"]
    assert server.get(path, Range="bytes=0-3", If_Range=etag).status_code == 206


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
