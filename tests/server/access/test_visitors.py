"""Admission of visitors, with a clock that the tests move."""

from __future__ import annotations

import asyncio
import dataclasses
from collections.abc import Callable

import pytest
from sqlalchemy.exc import OperationalError
from starlette.requests import HTTPConnection

from jobs.records.keys import Key, Scope
from server.access import visitors as module
from server.access.signed_tokens import SignedToken
from server.access.visitors import COOKIE, Access, Asking, Visitor
from tests.server.access_keys import FakeKeys


@dataclasses.dataclass
class Clock:
    now: float = 1000.0

    def __call__(self) -> float:
        return self.now


def asked(query: str = "", **headers: str) -> HTTPConnection:
    named = [(name.replace("_", "-").lower().encode(), value.encode()) for name, value in headers.items()]
    if "Host" not in headers:
        named.append((b"host", b"127.0.0.1:8000"))
    client = ("127.0.0.1", 50000)
    return HTTPConnection({"type": "http", "headers": named, "query_string": query.encode(), "client": client})


@pytest.fixture(autouse=True)
def always_fresh(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "FRESH_SECONDS", 0.0)


@pytest.fixture
def keys() -> FakeKeys:
    return FakeKeys()


def visitor(access: Access, connection: HTTPConnection) -> Visitor | None:
    return asyncio.run(access.visitor(connection))


def is_open(access: Access, connection: HTTPConnection | None = None) -> bool:
    return asyncio.run(access.open_to(connection or asked()))


def test_on_this_machine_a_key_is_asked_for_once_there_is_one(keys: FakeKeys) -> None:
    access = Access(keys, Asking.IF_ANY)
    assert is_open(access)
    keys.add("anna", Scope.VIEW)
    assert not is_open(access)


@pytest.mark.parametrize("header", ["Forwarded", "X_Forwarded_For"])
def test_a_proxy_on_this_machine_opens_it_to_nobody(keys: FakeKeys, header: str) -> None:
    assert not is_open(Access(keys, Asking.IF_ANY), asked(**{header: "for=192.0.2.1"}))


def test_a_server_that_always_asks_stays_closed_when_the_last_key_is_revoked(keys: FakeKeys) -> None:
    assert not is_open(Access(keys, Asking.ALWAYS))
    assert is_open(Access(keys, Asking.NEVER))


def test_a_key_in_the_header_lets_in_until_it_is_revoked_or_expires(keys: FakeKeys) -> None:
    clock = Clock()
    access = Access(keys, Asking.ALWAYS, clock)
    text = keys.add("anna", Scope.SUBMIT, expires=2000.0)
    found = visitor(access, asked(Authorization=f"Bearer {text}"))
    assert found is not None
    assert found.allows(Scope.SUBMIT)
    assert not found.allows(Scope.PUBLISH)
    assert access.seconds_left(found) == 1000.0
    assert visitor(access, asked(Authorization=f"Bearer {text}x")) is None
    assert visitor(access, asked(Authorization=f"Basic {text}")) is None
    clock.now = 2000.0
    assert visitor(access, asked(Authorization=f"Bearer {text}")) is None
    clock.now = 1000.0
    keys.keys.clear()
    assert visitor(access, asked(Authorization=f"Bearer {text}")) is None


@pytest.fixture
def link(keys: FakeKeys) -> Callable[[Access, str], str]:
    def make(access: Access, maker: str = "") -> str:
        key: Key | None = keys.keys.get(maker)

        async def made() -> str:
            return await access.sign(await access.link("studio", 60, key))

        return asyncio.run(made())

    return make


def test_a_link_lets_look_until_it_expires_or_its_maker_is_revoked(
    keys: FakeKeys, link: Callable[[Access, str], str]
) -> None:
    clock = Clock()
    access = Access(keys, Asking.ALWAYS, clock)
    keys.add("otto", Scope.PUBLISH)
    text = link(access, "otto")
    found = visitor(access, asked(f"link={text}"))
    assert found is not None
    assert (found.allows(Scope.VIEW), found.allows(Scope.SUBMIT)) == (True, False)
    clock.now = 1059.9
    assert visitor(access, asked(f"link={text}")) is not None
    clock.now = 1060.0
    assert visitor(access, asked(f"link={text}")) is None
    clock.now = 1000.0
    keys.keys.clear()
    assert visitor(access, asked(f"link={text}")) is None


def test_a_session_ends_with_its_key_and_is_no_link(keys: FakeKeys) -> None:
    access = Access(keys, Asking.ALWAYS, Clock())
    begun = asyncio.run(access.session(keys.add("anna", Scope.VIEW)))
    assert begun is not None
    cookie = asked(Cookie=f"{COOKIE}={begun[0]}")
    found = visitor(access, cookie)
    assert found is not None
    assert (found.by_cookie, found.key) == (True, keys.keys["anna"])
    assert visitor(access, asked(f"link={begun[0]}")) is None
    keys.keys.clear()
    assert visitor(access, cookie) is None
    assert asyncio.run(access.session("hgs_0")) is None


def test_a_link_is_no_session(keys: FakeKeys, link: Callable[[Access, str], str]) -> None:
    access = Access(keys, Asking.ALWAYS, Clock())
    assert visitor(access, asked(Cookie=f"{COOKIE}={link(access, '')}")) is None


def test_keys_that_are_known_hold_for_a_while_without_the_database(
    keys: FakeKeys, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    access = Access(keys, Asking.ALWAYS, Clock())
    text = keys.add("anna", Scope.VIEW)
    assert visitor(access, asked(Authorization=f"Bearer {text}")) is not None
    keys.fault = OperationalError("", {}, Exception("gone"))
    assert visitor(access, asked(Authorization=f"Bearer {text}")) is not None
    monkeypatch.setattr(module, "STALE_SECONDS", -1.0)
    caplog.clear()
    with pytest.raises(OperationalError):
        visitor(access, asked(Authorization=f"Bearer {text}"))
    assert "the key database does not respond: gone" in caplog.text


def test_a_new_key_works_at_once(keys: FakeKeys, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "FRESH_SECONDS", 1000.0)
    monkeypatch.setattr(module, "AT_ONCE_SECONDS", 0.0)
    access = Access(keys, Asking.ALWAYS, Clock())
    assert not is_open(access)
    assert visitor(access, asked(Authorization=f"Bearer {keys.add('anna', Scope.VIEW)}")) is not None


def test_a_token_says_nothing_of_its_own_scope() -> None:
    assert Visitor(link=SignedToken("link", 0, "", "studio")).allows(Scope.ADMIN) is False
