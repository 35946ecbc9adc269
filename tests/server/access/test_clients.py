from __future__ import annotations

import pytest
from starlette.requests import HTTPConnection

from jobs.records.keys import Key
from server.access.clients import client_of
from server.access.visitors import Visitor


def connection(address: str, visitor: Visitor | None = None) -> HTTPConnection:
    return HTTPConnection({"type": "http", "headers": [], "client": (address, 1234), "state": {"visitor": visitor}})


@pytest.mark.parametrize(
    ("address", "client"),
    [
        ("192.0.2.7", "address 192.0.2.7/32"),
        ("2001:db8::1:2:3:4", "address 2001:db8::/64"),  # one client has all of it
        ("testclient", "address testclient"),
    ],
)
def test_without_a_key_the_address_counts(address: str, client: str) -> None:
    assert client_of(connection(address)) == client
    assert client_of(connection(address, Visitor())) == client


def test_a_key_counts_from_any_address() -> None:
    visitor = Visitor(Key("k1", "anna", frozenset(), "", 0.0))
    assert {client_of(connection(address, visitor)) for address in ("192.0.2.7", "2001:db8::1")} == {"key k1"}
