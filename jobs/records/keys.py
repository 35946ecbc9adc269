"""Keys that let people and programs in, and the server's secret that links are signed with: both in the database."""

from __future__ import annotations

import hashlib
import re
import secrets
import time
from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum

import sqlalchemy as sa
from sqlalchemy.exc import IntegrityError

from hgs_core.base.errors import InputError
from jobs.home.database import create_engine, prepare_database
from jobs.home.home import Home
from jobs.records.job_table import metadata

__all__ = ["IMPLIED", "Key", "KeyTable", "Scope", "key_id", "key_matches"]

_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,63}")
_KEY = re.compile(r"hgs_([0-9a-f]{12})_([A-Za-z0-9_-]{43})")

_keys = sa.Table(
    "hgs_key",
    metadata,
    sa.Column("id", sa.String(12), primary_key=True),
    sa.Column("name", sa.String(64), nullable=False, unique=True),
    sa.Column("scopes", sa.Text, nullable=False),
    sa.Column("hash", sa.String(64), nullable=False),
    sa.Column("created", sa.Float(53), nullable=False),
    sa.Column("expires", sa.Float(53), nullable=True),
)

_secrets = sa.Table(
    "hgs_secret",
    metadata,
    sa.Column("name", sa.String(32), primary_key=True),
    sa.Column("value", sa.String(64), nullable=False),
)


class Scope(StrEnum):
    """The permissions of a key."""

    VIEW = "view"  # look at scenes
    SUBMIT = "submit"  # captures and jobs
    PUBLISH = "publish"  # rename and delete scenes, and make links to them
    ADMIN = "admin"  # everything


IMPLIED = {
    Scope.VIEW: frozenset({Scope.VIEW}),
    Scope.SUBMIT: frozenset({Scope.SUBMIT, Scope.VIEW}),
    Scope.PUBLISH: frozenset({Scope.PUBLISH, Scope.VIEW}),
    Scope.ADMIN: frozenset(Scope),
}
"""The permissions of each scope."""


@dataclass(frozen=True)
class Key:
    """A key as it is kept: its secret is not."""

    id: str
    name: str
    scopes: frozenset[Scope]
    hash: str  # SHA-256 of the whole key, hex
    created: float  # seconds since the epoch
    expires: float | None = None

    def allows(self, scope: Scope) -> bool:
        """Return whether one of its scopes is or implies `scope`."""
        return any(scope in IMPLIED[one] for one in self.scopes)

    def valid(self, now: float) -> bool:
        """Return whether it has not expired."""
        return self.expires is None or now < self.expires


class KeyTable:
    """The keys of a home. Methods block for one short transaction; safe to use from several threads."""

    def __init__(self, home: Home) -> None:
        """Open the home's database, and create it and the tables where they are missing.

        Raises:
            InputError: the home's folder is not the one that its database belongs to.
        """
        self._engine = create_engine(home)
        try:
            prepare_database(home, self._engine, metadata)
        except BaseException:
            self._engine.dispose()
            raise

    def close(self) -> None:
        """Close the database's connections."""
        self._engine.dispose()

    def add(self, name: str, scopes: Collection[Scope], expires: float | None = None) -> str:
        """Make a key and return it; only its SHA-256 is kept, which is enough for 32 random bytes.

        Raises:
            InputError: the name is malformed or taken, or there is no scope.
        """
        if not _NAME.fullmatch(name):
            raise InputError(f"key {name!r}", "is no name", "give 1 to 64 of a-z 0-9 _ -, beginning with a-z or 0-9")
        if not scopes:
            raise InputError(f"key {name}", "has no scope", f"give one of {', '.join(Scope)}")
        identity = secrets.token_hex(6)
        key = f"hgs_{identity}_{secrets.token_urlsafe(32)}"
        row = {
            "id": identity,
            "name": name,
            "scopes": " ".join(sorted(scopes)),
            "hash": _hash(key),
            "created": time.time(),
            "expires": expires,
        }
        try:
            with self._engine.begin() as connection:
                connection.execute(sa.insert(_keys).values(row))
        except IntegrityError as error:
            raise InputError(f"key {name}", "is there already", "revoke it first, or choose another name") from error
        return key

    def all(self) -> list[Key]:
        """Return all keys by name, expired ones too."""
        with self._engine.connect() as connection:
            rows = connection.execute(sa.select(_keys).order_by(_keys.c.name)).all()
        return [Key(r.id, r.name, frozenset(map(Scope, r.scopes.split())), r.hash, r.created, r.expires) for r in rows]

    def revoke(self, name: str) -> None:
        """Take a key back.

        Raises:
            InputError: there is no such key.
        """
        with self._engine.begin() as connection:
            if connection.execute(sa.delete(_keys).where(_keys.c.name == name)).rowcount == 0:
                raise InputError(f"key {name}", "there is no such key", "hgs keys ls shows those there are")

    def secret(self) -> bytes:
        """Return the 32 random bytes that every server process of the home signs links with; made when first asked."""
        query = sa.select(_secrets.c.value).where(_secrets.c.name == "links")
        with self._engine.connect() as connection:
            value = connection.execute(query).scalar_one_or_none()
        if value is None:
            try:
                with self._engine.begin() as connection:
                    connection.execute(sa.insert(_secrets).values(name="links", value=secrets.token_hex(32)))
            except IntegrityError:
                pass  # another process was faster
            with self._engine.connect() as connection:
                value = connection.execute(query).scalar_one()
        return bytes.fromhex(value)


def key_id(text: str) -> str | None:
    """Return the id in a key's text; None if it is no key."""
    found = _KEY.fullmatch(text)
    return found and found[1]


def key_matches(key: Key, text: str) -> bool:
    """Return whether `text` is the key, in a time that does not tell how much of it is."""
    return secrets.compare_digest(key.hash, _hash(text))


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
