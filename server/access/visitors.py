"""Visitors and their permissions: keys, browser sessions and links."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from sqlalchemy.exc import OperationalError
from starlette.concurrency import run_in_threadpool
from starlette.requests import HTTPConnection

from jobs.records.keys import Key, Scope, key_id, key_matches
from server.access.direct_requests import sign_of_proxy
from server.access.signed_tokens import SignedToken, read_token, sign_token

__all__ = ["COOKIE", "LINK", "Access", "Asking", "Keys", "Visitor"]

log = logging.getLogger("hgs.server")

COOKIE = "hgs_session"
LINK = "link"  # parameter of the query
FRESH_SECONDS = 1.0  # longest time that a revoked key keeps working
AT_ONCE_SECONDS = 0.1  # age of the cached keys that allows a reload for an unknown key: it may be new
STALE_SECONDS = 60.0  # longest use of cached keys while the database is down
SESSION_SECONDS = 30 * 24 * 3600


class Asking(Enum):
    """Conditions under which a key is required."""

    NEVER = "never"  # --open
    IF_ANY = "if any"  # loopback: once keys exist, or where a request may come from elsewhere
    ALWAYS = "always"


class Keys(Protocol):
    """The part of `jobs.records.keys.KeyTable` that the server uses."""

    def all(self) -> list[Key]: ...  # noqa: D102
    def secret(self) -> bytes: ...  # noqa: D102


@dataclass(frozen=True)
class Visitor:
    """A visitor with a key, with a link to one scene, or anonymous where no key is required."""

    key: Key | None = None
    link: SignedToken | None = None
    by_cookie: bool = False  # browsers send the cookie for any page

    def allows(self, scope: Scope) -> bool:
        """Return whether the visitor has `scope`; a link has only VIEW, for its own scene."""
        if self.key is not None:
            return self.key.allows(scope)
        return self.link is None or scope is Scope.VIEW


class Access:
    """Cached keys of a server."""

    def __init__(self, keys: Keys | None, asking: Asking, clock: Callable[[], float] = time.time) -> None:
        """Require keys as `asking` says, or never without a table of keys. `clock` returns seconds since the epoch."""
        self._table, self._asking, self._clock = keys, asking if keys is not None else Asking.NEVER, clock
        self._keys: dict[str, Key] = {}
        self._secret = b""
        self._read = -STALE_SECONDS

    @property
    def asking(self) -> Asking:
        """Condition under which a key is required."""
        return self._asking

    async def open_to(self, connection: HTTPConnection) -> bool:
        """Return whether a request needs no key.

        Raises:
            OperationalError: the database has been unreachable for more than `STALE_SECONDS`.
        """
        if self._asking is Asking.NEVER:
            return True
        await self._refresh()
        return self._asking is Asking.IF_ANY and not self._keys and sign_of_proxy(connection) is None

    def why_closed(self, connection: HTTPConnection) -> str | None:
        """Return why a server without keys rejects this request; None if the server has keys."""
        if self._asking is not Asking.IF_ANY or self._keys:
            return None
        sign = sign_of_proxy(connection)
        return f"it has no keys yet, so it accepts only requests from its own machine; this request shows {sign}"

    async def visitor(self, connection: HTTPConnection) -> Visitor | None:
        """Return the visitor with this `Authorization: Bearer KEY`, link or cookie; None if none of them is valid.

        Raises:
            OperationalError: as `open_to`.
        """
        await self._refresh()
        scheme, _, text = connection.headers.get("Authorization", "").partition(" ")
        if scheme.lower() == "bearer":
            key = await self._found(text.strip())
            return None if key is None else Visitor(key)
        if (link := connection.query_params.get(LINK)) is not None:
            token = self._token(link)
            return Visitor(link=token) if token is not None and token.kind == "link" else None
        session = self._token(connection.cookies.get(COOKIE, ""))
        if session is not None and session.kind == "session":
            return Visitor(self._keys[session.key], by_cookie=True)
        return None

    async def session(self, text: str) -> tuple[str, Key] | None:
        """Return a session token and its key, or None for an unknown key."""
        await self._refresh()
        key = await self._found(text)
        if key is None:
            return None
        expires = self._clock() + SESSION_SECONDS
        expires = expires if key.expires is None else min(expires, key.expires)
        return sign_token(SignedToken("session", int(expires), key.id), self._secret), key

    async def link(self, scene: str, seconds: int, key: Key | None) -> SignedToken:
        """Return the token of a link to a scene, valid for `seconds` and at most as long as the key that made it."""
        await self._refresh()
        return SignedToken("link", int(self._clock()) + seconds, key.id if key else "", scene)

    async def sign(self, token: SignedToken) -> str:
        """Return a token as text."""
        if not self._secret and self._table is not None:
            self._secret = await run_in_threadpool(self._table.secret)
        return sign_token(token, self._secret)

    def seconds_left(self, visitor: Visitor) -> float:
        """Return the seconds until a visitor's key or link expires; 0 or less if it has expired."""
        ends = [end for end in (visitor.key and visitor.key.expires, visitor.link and visitor.link.expires) if end]
        return min(ends, default=float("inf")) - self._clock()

    async def _found(self, text: str) -> Key | None:
        """Return the key with this text; reload the table if it may be new."""
        identity = key_id(text)
        if identity is not None and identity not in self._keys:
            await self._refresh(AT_ONCE_SECONDS)
        key = self._keys.get(identity or "")
        return key if key is not None and key_matches(key, text) and key.valid(self._clock()) else None

    def _token(self, text: str) -> SignedToken | None:
        token = read_token(text, self._secret, self._clock()) if self._secret else None
        if token is None or not token.key:
            return token if token is not None and token.kind == "link" else None
        key = self._keys.get(token.key)
        return token if key is not None and key.valid(self._clock()) else None

    async def _refresh(self, kept: float | None = None) -> None:
        now = time.monotonic()
        if self._table is None or now - self._read < (FRESH_SECONDS if kept is None else kept):
            return
        try:
            keys = await run_in_threadpool(self._table.all)
            if not self._secret:
                self._secret = await run_in_threadpool(self._table.secret)
        except OperationalError as error:
            log.error("the key database does not respond: %s", error.orig)
            if now - self._read > STALE_SECONDS:
                raise
            return
        self._keys, self._read = {key.id: key for key in keys}, now
