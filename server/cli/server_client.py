"""Requests to a server elsewhere: soon given up where nobody answers, with patience for lines that break."""

from __future__ import annotations

import argparse
import contextlib
import http.client
import json
import os
import re
import socket
import ssl
import sys
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self
from urllib.parse import SplitResult, urlsplit

from tqdm import tqdm

from hgs_core.base.errors import InputError
from hgs_core.base.progress import StageStopped
from server.cli.job_words import duration

__all__ = ["FIRST_PATIENCE", "Answer", "LostConnectionError", "RefusedError", "ServerClient", "add_patience_option"]

FIRST_PATIENCE = 10.0
"""Seconds after which a server that never answered is given up."""

_TIMEOUT = 120.0  # seconds that a connection may be silent
_PATIENCE = 600.0  # seconds without any success after which a server that answered before is given up
_LONGEST_WAIT = 20.0  # seconds between two tries
_LONGEST_PATIENCE = 1e6  # seconds
_HOST = re.compile(r"[\w.:%-]+")
_MAY_PASS = frozenset((408, 429, 502, 503, 504))  # answers that may differ at another try


@dataclass(frozen=True)
class Answer:
    """A server's answer."""

    status: int
    headers: Mapping[str, str]
    value: Any  # None without a JSON body


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
    """A broken connection, or an answer that calls for another try."""


def add_patience_option(parser: argparse.ArgumentParser) -> None:
    """Add --patience."""
    parser.add_argument(
        "--patience",
        metavar="SECONDS",
        type=float,
        default=FIRST_PATIENCE,
        help="how long to try a server that does not answer (default: %(default)g)",
    )


class ServerClient:
    """A client of one server; safe to use from several threads, each of which has its own connection."""

    def __init__(self, url: str, patience: float = FIRST_PATIENCE) -> None:
        """Connect to nothing yet; `HGS_KEY` in the environment is the key that the server may ask for.

        `patience` is for how many seconds a server is tried that never answered; one that did is tried for 10 minutes
        at least.

        Raises:
            InputError: the URL is none of a server, or the patience is negative.
        """
        if not 0 <= patience < _LONGEST_PATIENCE:
            cure = f"give 0 to {_LONGEST_PATIENCE:.0f}"
            raise InputError("--patience", f"{patience:g} is no number of seconds to wait", cure)
        self._parts = _parts(url)
        self.url = url.rstrip("/")
        self._answered = False
        self._stopped = threading.Event()
        self._own = threading.local()
        self._connections: list[http.client.HTTPConnection] = []  # those of all threads
        self._patience = patience
        self._failing: float | None = None  # monotonic seconds

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
            if not (key.isascii() and key.isprintable()):
                raise InputError("HGS_KEY", "holds what no key does", "set it to what hgs keys add printed")
            sent["Authorization"] = f"Bearer {key}"
        if json_body is not None:
            sent["Content-Type"], body = "application/json", json.dumps(json_body).encode()
        began = time.monotonic()
        try:
            answer = self._exchange(method, self._parts.path.rstrip("/") + path, sent, body)
        except ssl.SSLError as error:  # another try would end alike
            self._drop()
            reason = getattr(error, "verify_message", "") or error.reason or str(error)
            cure = "is it http:// there? else mend the server's certificate"
            raise InputError(self.url, f"cannot be reached safely ({reason})", cure) from error
        except (OSError, http.client.HTTPException) as error:
            self._drop()
            self._failing = began if self._failing is None else self._failing
            reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
            raise LostConnectionError(reason) from error
        if answer.status in _MAY_PASS:
            detail = answer.value.get("detail") if isinstance(answer.value, dict) else None
            raise LostConnectionError(detail or f"the server answered {answer.status}")
        self._failing, self._answered = None, True
        if answer.status >= 400:
            raise RefusedError(self.url, answer)
        if method == "GET" and not isinstance(answer.value, dict):
            raise InputError(self.url, "does not answer as a server of HGS does", "check the address and the port")
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
        """Wait before another try, longer each time; the first time say so.

        Raises:
            InputError: nothing has succeeded for long.
            StageStopped: `stop` was called.
        """
        seconds = min(_LONGEST_WAIT, 0.5 * 2 ** min(tries, 10))
        now = time.monotonic()
        self._failing = now if self._failing is None else self._failing
        patience = max(self._patience, _PATIENCE) if self._answered else self._patience
        if now + seconds - self._failing > patience:
            cure = "check the address, or give it longer with --patience 600"
            cure = "run the same command again to go on" if self._answered else cure
            raise InputError(self.url, f"the server cannot be reached ({reason})", cure) from reason
        if tries == 0:
            line = f"{self.url}: cannot be reached ({reason}), trying again for {duration(patience)}"
            tqdm.write(line, file=sys.stderr)
        if self._stopped.wait(seconds):
            raise StageStopped

    def stop(self) -> None:
        """End the waits of other threads: for their next try or an answer."""
        self._stopped.set()
        for connection in list(self._connections):
            with contextlib.suppress(OSError, AttributeError):
                connection.sock.shutdown(socket.SHUT_RDWR)

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
            # One that never answered is given no longer than it is tried.
            timeout = _TIMEOUT if self._answered else min(_TIMEOUT, max(1.0, self._patience))
            if self._parts.scheme == "https":
                found = http.client.HTTPSConnection(host, port, timeout=timeout, context=ssl.create_default_context())
            else:
                found = http.client.HTTPConnection(host, port, timeout=timeout)
            self._own.connection = found
            self._connections.append(found)
            found.connect()
        if self._stopped.is_set():  # connected: `stop` may end it now
            raise StageStopped
        return found

    def _drop(self) -> None:
        connection = getattr(self._own, "connection", None)
        if connection is not None:
            connection.close()
            self._own.connection = None
            self._connections.remove(connection)


def _parts(url: str) -> SplitResult:
    """Return the parts of a server's address.

    Raises:
        InputError: it is none.
    """
    try:
        parts = urlsplit(url)
        host = parts.hostname or ""
        host.encode("idna")
        parts.path.encode("ascii")
        known = parts.scheme in ("http", "https") and _HOST.fullmatch(host) and parts.port != 0
        if known and not (parts.query or parts.fragment or any(map(str.isspace, url))):
            return parts
    except ValueError:  # a bad port, bracket or host name
        pass
    raise InputError(f"{url[:100]!r}", "is not the address of a server", "give it as in http://host:8000")
