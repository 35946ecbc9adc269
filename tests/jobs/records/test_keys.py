from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from jobs.records.keys import Key, KeyTable, Scope, key_id, key_matches


@pytest.fixture
def home(tmp_path: Path) -> Home:
    return Home.at(tmp_path / "home")


@pytest.fixture
def table(home: Home) -> Iterator[KeyTable]:
    with closing(KeyTable(home)) as opened:
        yield opened


def test_a_key_is_kept_as_a_hash_alone(table: KeyTable, home: Home) -> None:
    text = table.add("anna", {Scope.SUBMIT})
    [key] = table.all()
    assert (key.name, key.scopes, key.expires) == ("anna", {Scope.SUBMIT}, None)
    assert key_id(text) == key.id
    assert key_matches(key, text)
    assert not key_matches(key, text[:-1] + ("a" if text[-1] != "a" else "b"))
    secret = text.split("_", 2)[2]
    with closing(sqlite3.connect(home.folder / "jobs.sqlite")) as database:
        assert not any(secret in line for line in database.iterdump())


def test_names_are_unique_until_a_key_is_revoked(table: KeyTable) -> None:
    first = table.add("anna", {Scope.VIEW})
    with pytest.raises(InputError, match="key anna: is there already"):
        table.add("anna", {Scope.VIEW})
    table.revoke("anna")
    assert table.add("anna", {Scope.VIEW}) != first
    with pytest.raises(InputError, match="key otto: there is no such key"):
        table.revoke("otto")


@pytest.mark.parametrize("name", ["", "Anna", "-a", "a" * 65, "a b"])
def test_a_name_that_is_none_is_refused(table: KeyTable, name: str) -> None:
    with pytest.raises(InputError, match="is no name"):
        table.add(name, {Scope.VIEW})


@pytest.mark.parametrize(
    ("scope", "allowed"),
    [("view", "view"), ("submit", "submit view"), ("publish", "publish view"), ("admin", "admin publish submit view")],
)
def test_what_scopes_allow(scope: str, allowed: str) -> None:
    key = Key("", "", frozenset({Scope(scope)}), "", 0.0)
    assert sorted(one for one in Scope if key.allows(one)) == allowed.split()


def test_a_key_can_expire(table: KeyTable) -> None:
    table.add("anna", {Scope.VIEW}, expires=1000.0)
    [key] = table.all()
    assert (key.valid(999.9), key.valid(1000.0)) == (True, False)


def test_every_process_signs_with_the_same_secret(table: KeyTable, home: Home) -> None:
    with closing(KeyTable(home)) as other:
        assert len(table.secret()) == 32
        assert other.secret() == table.secret()


@pytest.mark.parametrize("text", ["", "hgs_", "hgs_0123456789ab_short", "bearer x"])
def test_other_texts_are_no_keys(text: str) -> None:
    assert key_id(text) is None
