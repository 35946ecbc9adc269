from __future__ import annotations

import pytest
from starlette.requests import HTTPConnection

from server.access.origins import OriginPolicy


def asked(host: str = "scenes.example:8000", origin: str | None = None) -> HTTPConnection:
    headers = [(b"host", host.encode())] + ([(b"origin", origin.encode())] if origin is not None else [])
    return HTTPConnection({"type": "http", "headers": headers})


@pytest.mark.parametrize(
    ("origin", "same"),
    [
        (None, True),  # no page
        ("http://scenes.example:8000", True),
        ("https://scenes.example:8000", True),  # the server knows not what a proxy before it speaks
        ("http://scenes.example", False),
        ("http://scenes.example:8000.evil.example", False),
        ("https://elsewhere.example", False),
        ("null", False),
        ("", False),
    ],
)
def test_pages_of_the_server_are_told_from_others(origin: str | None, same: bool) -> None:
    assert OriginPolicy().same_site(asked(origin=origin)) is same
    assert OriginPolicy().may_read(asked(origin=origin)) is same


def test_pages_of_named_origins_may_read_and_are_no_less_foreign() -> None:
    open_ = OriginPolicy(frozenset({"https://a.example"}))
    assert open_.may_read(asked(origin="https://a.example"))
    assert not open_.may_read(asked(origin="http://a.example"))
    assert not open_.same_site(asked(origin="https://a.example"))


def test_a_star_lets_every_page_read() -> None:
    assert OriginPolicy(frozenset("*")).may_read(asked(origin="https://a.example"))
