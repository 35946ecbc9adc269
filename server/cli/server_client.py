"""Requests to a server elsewhere, with patience for lines that break."""

from __future__ import annotations

import http.client
import json
import os
import ssl
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self
from urllib.parse import urlsplit

from hgs_core.base.errors import InputError

__all__ = ["Answer", "LostConnectionError", "RefusedError", "ServerClient"]

_TIMEOUT = 120.0  # seconds that a connection may be silent
_PATIENCE = 600.0  # seconds without any success after which nothing is tried again
_LONGEST_WAIT = 20.0  # seconds between two tries
_MAY_PASS = frozenset((408, 429, 502, 503, 504))  # that another try may not get


@dataclass(frozen=True)
class Answer:
    """What a server answered."""

    status: int
    headers: Mapping[str, str]
    value: Any  # of a JSON body, else None


class RefusedError(InputError):
    """An answer of 400 or more that another try would get too."""

    def __init__(self, where: str, answer: Answer) -> None:
        """Keep status and code; the line is the server's own."""
        told = answer.value if isinstance(answer.value, dict) else {}
        self.status = answer.status
        self.code = str(told.get("code", ""))
        cure = "set HGS_KEY to a key of that server" if answer.status == 401 else ""
        super().__init__(where, str(told.get("detail", f"the server answered {answer.status}")), cure)


class LostConnectionError(Exception):
    """A connection broke, or the server answered what may pass."""


class ServerClient:
    """A client of one server; safe to use from several threads, each of which has its own connection."""

    def __init__(self, url: str, patience: float = _PATIENCE) -> None:
        """Connect to nothing yet; `HGS_KEY` in the environment is the key that the server may ask for.

        Raises:
            InputError: the URL is none of a server.
        """
        parts = urlsplit(url)
        try:
            port = parts.port
        except ValueError:
            port = -1
        if parts.scheme not in ("http", "https") or not parts.hostname or port == -1 or parts.query or parts.fragment:
            raise InputError("--to", f"{url!r} is not the address of a server", "give it as in http://host:8000")
        self.url = url.rstrip("/")
        self._parts = parts
        self._own = threading.local()
        self._connections: list[http.client.HTTPConnection] = []  # those of all threads
        self._patience = patience
        self._failing: float | None = None  # since when

    def once(
        self,
        method: str,
        path: str,
        *,
        headers: Mapping[str, str] | None = None,
        body: bytes = b"",
        json_body: Any = None,
    ) -> Answer:
        """Send one request.

        Raises:
            LostConnectionError: no answer came, or one that may pass.
            RefusedError: another answer of 400 or more.
        """
        sent = dict(headers or {})
        if key := os.environ.get("HGS_KEY"):
            sent["Authorization"] = f"Bearer {key}"
        if json_body is not None:
            sent["Content-Type"], body = "application/json", json.dumps(json_body).encode()
        try:
            answer = self._exchange(method, self._parts.path.rstrip("/") + path, sent, body)
        except (OSError, http.client.HTTPException) as error:
            self._drop()
            raise LostConnectionError(str(error) or type(error).__name__) from error
        if answer.status in _MAY_PASS:
            detail = answer.value.get("detail") if isinstance(answer.value, dict) else None
            raise LostConnectionError(detail or f"the server answered {answer.status}")
        self._failing = None
        if answer.status >= 400:
            raise RefusedError(self.url, answer)
        return answer

    def request(self, method: str, path: str, **arguments: Any) -> Answer:
        """Send a request that may be sent twice, until it is answered.

        Raises:
            InputError: the server refuses it, or has not answered for long.
        """
        tries = 0
        while True:
            try:
                return self.once(method, path, **arguments)
            except LostConnectionError as error:
                self.wait(tries, error)
                tries += 1

    def wait(self, tries: int, reason: Exception) -> None:
        """Wait before another try, longer each time.

        Raises:
            InputError: nothing has succeeded for long.
        """
        seconds = min(_LONGEST_WAIT, 0.5 * 2 ** min(tries, 10))
        now = time.monotonic()
        self._failing = now if self._failing is None else self._failing
        if now + seconds - self._failing > self._patience:
            cure = "run the same command again to go on"
            raise InputError(self.url, f"the server cannot be reached ({reason})", cure) from reason
        time.sleep(seconds)

    def close(self) -> None:
        """Close the connections of all threads."""
        for connection in self._connections:
            connection.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()

    def _exchange(self, method: str, path: str, headers: Mapping[str, str], body: bytes) -> Answer:
        connection = self._connection()
        connection.request(method, path, body or (None if method in ("GET", "HEAD") else b""), dict(headers))
        response = connection.getresponse()
        content = response.read()
        told = {name.lower(): value for name, value in response.getheaders()}
        if response.will_close:
            self._drop()
        is_json = "json" in told.get("content-type", "")
        try:
            value = json.loads(content) if is_json and content else None
        except ValueError as error:
            raise http.client.HTTPException("the answer is cut") from error
        return Answer(response.status, told, value)

    def _connection(self) -> http.client.HTTPConnection:
        found: http.client.HTTPConnection | None = getattr(self._own, "connection", None)
        if found is None:
            host, port = str(self._parts.hostname), self._parts.port
            if self._parts.scheme == "https":
                found = http.client.HTTPSConnection(host, port, timeout=_TIMEOUT, context=ssl.create_default_context())
            else:
                found = http.client.HTTPConnection(host, port, timeout=_TIMEOUT)
            self._own.connection = found
            self._connections.append(found)
        return found

    def _drop(self) -> None:
        connection = getattr(self._own, "connection", None)
        if connection is not None:
            connection.close()
            self._own.connection = None
            self._connections.remove(connection)
