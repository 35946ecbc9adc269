from __future__ import annotations

from typing import Any

import pytest


@pytest.mark.parametrize(
    ("method", "path", "allowed"),
    [
        ("GET", "/v1/links", "POST"),
        ("HEAD", "/v1/links", "POST"),
        ("GET", "/v1/jobs/a/cancel", "POST"),
        ("DELETE", "/v1/jobs", "GET, HEAD, POST"),
        ("PUT", "/v1/jobs/a", "DELETE, GET, HEAD"),
        ("GET", "/v1/uploads/a/finish", "POST"),
        ("POST", "/v1/captures", "GET, HEAD"),
        ("PATCH", "/v1/session", "DELETE, GET, HEAD, POST"),
    ],
)
def test_a_method_that_an_address_does_not_take_is_405_with_those_that_it_takes(
    server: Any, method: str, path: str, allowed: str
) -> None:
    answer = server.request(method, path)
    assert (answer.status_code, answer.headers["allow"]) == (405, allowed)
    assert answer.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize("method", ["GET", "DELETE", "POST", "PUT"])
def test_an_address_that_is_none_of_the_api_is_404_with_every_method(server: Any, method: str) -> None:
    assert server.request(method, "/v1/nonsense").json()["code"] == "not-found"


def test_pages_are_read_and_not_written(server: Any) -> None:
    answer = server.request("POST", "/new")
    assert (answer.status_code, set(answer.headers["allow"].split(", "))) == (405, {"GET", "HEAD"})
