"""Answers to conditional and range requests, against RFC 9110's rule for each header."""

from __future__ import annotations

import gzip
import hashlib
import json
from typing import Any

import pytest
import zstandard
from fastapi import Request, Response

from server.http.conditional import byte_range, entity_tag, respond, respond_compressed, respond_json
from server.http.content_coding import compress
from server.http.problems import ProblemError

DATA = bytes(range(256)) * 4
ETAG = '"tag"'
LONG = "9" * 5000


def request(method: str = "GET", **headers: str) -> Request:
    """Return a request with headers; underscores stand for hyphens."""
    lines = [(name.replace("_", "-").lower().encode(), value.encode()) for name, value in headers.items()]
    return Request({"type": "http", "method": method, "path": "/", "query_string": b"", "headers": lines})


def answer(method: str = "GET", **headers: str) -> Response:
    return respond(request(method, **headers), DATA, "text/plain", etag=ETAG, cache_control="no-cache", ranges=True)


def test_entity_tag_is_the_quoted_sha256_of_the_body() -> None:
    # Of the empty body: FIPS 180-4, as every implementation prints it.
    assert entity_tag(b"") == '"e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"'


def test_whole_body_comes_with_its_tag_and_how_long_it_may_be_kept() -> None:
    response = answer()
    assert (response.status_code, response.body) == (200, DATA)
    assert (response.headers["etag"], response.headers["cache-control"]) == (ETAG, "no-cache")
    assert response.headers["accept-ranges"] == "bytes"
    assert "vary" not in response.headers


@pytest.mark.parametrize("tags", [ETAG, f"W/{ETAG}", f'"other", {ETAG}', "*"])
def test_body_that_the_client_has_is_304_without_it(tags: str) -> None:
    response = answer(If_None_Match=tags)
    assert (response.status_code, response.body, response.headers["etag"]) == (304, b"", ETAG)


@pytest.mark.parametrize("tags", ['"other"', "tag", ""])
def test_other_tags_are_answered_with_the_body(tags: str) -> None:
    assert answer(If_None_Match=tags).status_code == 200


@pytest.mark.parametrize(
    ("asked", "first", "last"),
    [
        ("bytes=0-0", 0, 0),
        ("bytes=10-19", 10, 19),
        ("bytes=1000-", 1000, 1023),
        ("bytes=-24", 1000, 1023),
        ("bytes=1000-9999", 1000, 1023),
        ("bytes=-9999", 0, 1023),
        ("Bytes=5-6", 5, 6),
        ("bytes=0-" + LONG, 0, 1023),
        ("bytes=-" + LONG, 0, 1023),
        ("bytes=" + "0" * 5000 + "5-6", 5, 6),
    ],
    ids=lambda value: str(value)[:20],
)
def test_range_is_206(asked: str, first: int, last: int) -> None:
    response = answer(Range=asked)
    assert (response.status_code, response.body) == (206, DATA[first : last + 1])
    assert response.headers["content-range"] == f"bytes {first}-{last}/1024"


@pytest.mark.parametrize("asked", ["bytes=0-1,4-5", "lines=1-2", "bytes=-", "bytes=9-3", "bytes", "bytes=a-b"])
def test_ranges_that_are_not_served_get_the_whole(asked: str) -> None:
    assert (answer(Range=asked).status_code, answer(Range=asked).body) == (200, DATA)


@pytest.mark.parametrize("asked", ["bytes=1024-", "bytes=5000-6000", "bytes=-0", f"bytes={LONG}-"])
def test_range_behind_the_end_is_416_and_tells_the_size(asked: str) -> None:
    with pytest.raises(ProblemError, match="the body has 1024 bytes") as caught:
        byte_range(asked, 1024)
    assert (caught.value.status, caught.value.code) == (416, "range-not-satisfiable")
    assert caught.value.headers == {"Content-Range": "bytes */1024"}


def test_if_range_with_another_tag_gets_the_whole() -> None:
    assert answer(Range="bytes=0-3", If_Range='"other"').status_code == 200
    assert answer(Range="bytes=0-3", If_Range=ETAG).status_code == 206


def test_head_is_told_of_the_whole() -> None:
    assert (answer("HEAD", Range="bytes=0-3").status_code, answer("HEAD").headers["content-length"]) == (200, "1024")


def test_range_of_what_is_not_served_in_parts_gets_the_whole() -> None:
    response = respond(request(Range="bytes=0-3"), DATA, "text/plain", etag=ETAG, cache_control="no-cache")
    assert (response.status_code, "accept-ranges" in response.headers) == (200, False)


@pytest.mark.parametrize("coding", ["zstd", "gzip"])
def test_text_is_compressed_for_those_who_ask(coding: str) -> None:
    text = b"manifest " * 200
    response = respond_compressed(request(Accept_Encoding=coding), text, "text/plain")
    body = bytes(response.body)
    assert (response.headers["content-encoding"], response.headers["vary"]) == (coding, "Accept-Encoding")
    assert (gzip.decompress(body) if coding == "gzip" else zstandard.ZstdDecompressor().decompress(body)) == text
    assert response.headers["etag"] == f'"{hashlib.sha256(body).hexdigest()}"'  # digest of the sent bytes


def test_tag_of_one_coding_does_not_stand_for_another() -> None:
    text = b"manifest " * 200
    etag = respond_compressed(request(Accept_Encoding="gzip"), text, "text/plain").headers["etag"]
    same = respond_compressed(request(Accept_Encoding="gzip", If_None_Match=etag), text, "text/plain")
    other = respond_compressed(request(If_None_Match=etag), text, "text/plain")
    assert (same.status_code, same.headers["vary"]) == (304, "Accept-Encoding")
    assert (other.status_code, other.body) == (200, text)
    assert "content-encoding" not in other.headers


def test_text_is_compressed_once() -> None:
    compress.cache_clear()
    for _ in range(3):
        respond_compressed(request(Accept_Encoding="gzip"), b"manifest " * 200, "text/plain")
    assert compress.cache_info().misses == 1


def test_text_that_fits_into_one_packet_is_sent_as_it_is() -> None:
    response = respond_compressed(request(Accept_Encoding="gzip"), b"a" * 1023, "text/plain")
    assert (response.body, response.headers["vary"]) == (b"a" * 1023, "Accept-Encoding")


@pytest.mark.parametrize("value", [{"a": [1, None, "€"]}, [], "half \ud800"])
def test_json_is_utf8_whatever_the_text(value: Any) -> None:
    response = respond_json(request(), value)
    assert response.headers["content-type"] == "application/json"
    assert json.loads(response.body) == (value if value != "half \ud800" else "half ?")


def test_numbers_that_json_does_not_know_are_never_sent() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        respond_json(request(), float("nan"))
