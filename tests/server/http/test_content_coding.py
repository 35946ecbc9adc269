from __future__ import annotations

import gzip

import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st

from server.http.content_coding import IDENTITY, compress, preferred_coding


@pytest.mark.parametrize(
    ("header", "coding"),
    [
        (None, "identity"),
        ("", "identity"),
        ("gzip", "gzip"),
        ("gzip, deflate, br, zstd", "br"),
        ("GZIP", "gzip"),
        ("br;q=0.5, gzip;q=0.8", "gzip"),
        ("br ; q=0.5 , gzip ; q=0.5", "br"),
        ("br;q=0, gzip;q=0", "identity"),
        ("*", "br"),
        ("br;q=0, *", "gzip"),
        ("*;q=0", "identity"),
        ("identity, gzip;q=0.5", "identity"),
        ("identity;q=0.5, gzip;q=0.5", "gzip"),
        ("identity;q=0", "identity"),
        ("deflate", "identity"),
        ("gzip;q=nan", "identity"),
        ("gzip;q=2", "identity"),
        ("gzip;q=1.5", "gzip"),
        ("gzip;level=9", "identity"),
        (",,;q=,gzip", "gzip"),
    ],
)
def test_client_gets_the_coding_it_likes_best(header: str | None, coding: str) -> None:
    assert preferred_coding(header, ("br", "gzip")) == coding


@given(st.text(max_size=200))
def test_any_header_has_an_answer(header: str) -> None:
    assert preferred_coding(header, ("br", "gzip")) in ("br", "gzip", IDENTITY)


def test_bodies_come_back_from_every_coding() -> None:
    body = b"manifest " * 1000
    assert zstandard.ZstdDecompressor().decompress(compress(body, "zstd")) == body
    assert gzip.decompress(compress(body, "gzip")) == body
