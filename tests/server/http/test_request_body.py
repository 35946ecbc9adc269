from __future__ import annotations

import asyncio
from typing import Any

import pytest
from fastapi import Request
from pydantic import BaseModel, ConfigDict

from server.http.problems import ProblemError
from server.http.request_body import MAX_BODY_BYTES, read_json


class Order(BaseModel):
    """A body as a route describes it."""

    model_config = ConfigDict(extra="forbid", strict=True)
    name: str
    amount: int | float = 1
    more: Any = None


def read(body: bytes, content_type: str = "application/json", pieces: int = 1) -> Order:
    """Read a body that comes in pieces."""
    size = -(-len(body) // pieces)
    messages = [
        {"type": "http.request", "body": body[k * size : (k + 1) * size], "more_body": k + 1 < pieces}
        for k in range(pieces)
    ]

    async def receive() -> Any:
        return messages.pop(0)

    headers = [(b"content-type", content_type.encode())] if content_type else []
    return asyncio.run(read_json(Request({"type": "http", "headers": headers}, receive), Order))


def refusal(body: bytes, content_type: str = "application/json", pieces: int = 1) -> ProblemError:
    with pytest.raises(ProblemError) as caught:
        read(body, content_type, pieces)
    return caught.value


@pytest.mark.parametrize("content_type", ["application/json", "Application/JSON; charset=utf-8"])
def test_json_becomes_the_model(content_type: str) -> None:
    assert read(b'{"name": "\xe2\x82\xac", "amount": 2}', content_type, pieces=3) == Order(name="€", amount=2)


@pytest.mark.parametrize("content_type", ["", "text/plain", "application/x-www-form-urlencoded", "application/jsonx"])
def test_other_media_types_are_415(content_type: str) -> None:
    problem = refusal(b'{"name": "x"}', content_type)
    assert (problem.status, problem.code) == (415, "body-not-json")
    assert (content_type or "missing") in problem.detail


@pytest.mark.parametrize("body", [b"", b"{", b"\xff", b"[" * 60_000], ids=["empty", "cut", "not UTF-8", "deep"])
def test_what_is_not_json_is_400(body: bytes) -> None:
    problem = refusal(body)
    assert (problem.status, problem.code) == (400, "body-not-json")


def test_a_body_is_read_up_to_the_limit_and_not_further() -> None:
    whole = b'{"name": "%s"}' % (b"x" * (MAX_BODY_BYTES - 12))
    assert len(whole) == MAX_BODY_BYTES
    assert len(read(whole).name) == MAX_BODY_BYTES - 12
    problem = refusal(whole + b" ", pieces=9)
    assert (problem.status, problem.code) == (413, "body-too-large")


@pytest.mark.parametrize(
    ("body", "field"),
    [
        (b"[1]", ""),
        (b"{}", "name"),
        (b'{"name": 3}', "name"),
        (b'{"name": "x", "colour": "red"}', "colour"),
        (b'{"name": "x", "amount": NaN}', "amount"),
        (b'{"name": "x", "more": [1, {"a": -Infinity}]}', "more.1.a"),
        (b'{"name": "x", "amount": ' + b"9" * 5000 + b"}", "amount"),
        (b'{"name": "a\\u0000b"}', "name"),
        (b'{"name": "x", "more": ["\\ud800"]}', "more.0"),
        (b'{"name": "x", "more": {"\\ud800": 1}}', "more"),
    ],
)
def test_a_bad_field_is_422_and_named(body: bytes, field: str) -> None:
    problem = refusal(body)
    assert (problem.status, problem.code, problem.field) == (422, "body-invalid", field)
    assert problem.detail.startswith(f"{field or 'body'}: ")


def test_whole_numbers_of_64_bits_are_kept_as_they_are() -> None:
    assert read(b'{"name": "x", "amount": 9007199254740993}').amount == 2**53 + 1  # no double holds it
