"""Requests of a soak's clients, each noted in the history with its answer."""

from __future__ import annotations

import contextlib
import http.client
import json
import random
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from benchmarks.soak.request_history import Act, Event, History

__all__ = ["Answer", "Board", "ClientCalls"]

PATIENCE = 20.0  # seconds for an answer


@dataclass(frozen=True)
class Answer:
    """An answer: its status, 0 where none came, its JSON, its bytes and its headers, which have lower-case names."""

    status: int
    body: Any = None
    data: bytes = b""
    headers: Mapping[str, str] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether it says that all went well."""
        return 200 <= self.status < 300


class Board:
    """Notices that clients leave for each other; lists of ids are only ever added to."""

    def __init__(self, address: str, key: str, history: History) -> None:
        """Begin with the server's address and a key of scope `admin`."""
        self.address, self.key, self.history = address, key, history
        self.captures: list[str] = []
        self.scenes: list[str] = []
        self.keys: dict[str, str] = {}  # texts by name, revoked ones too
        self.submitted = threading.Event()  # the first job is acknowledged
        self.stop = threading.Event()


class ClientCalls:
    """The requests of one client; its dice decide everything that it does."""

    def __init__(self, name: str, board: Board, seed: int) -> None:
        """Begin."""
        self.name, self.board = name, board
        self.dice = random.Random(f"{seed} {name}")

    @property
    def over(self) -> bool:
        """Whether the soak takes no more requests."""
        return self.board.stop.is_set()

    def rest(self, seconds: float) -> bool:
        """Wait, and return whether the soak goes on."""
        return not self.board.stop.wait(seconds)

    def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        headers: Mapping[str, str] | None = None,
        key: str = "",
    ) -> Answer:
        """Send a request; `body` is bytes or JSON."""
        sent = {"Authorization": f"Bearer {key or self.board.key}", "Connection": "close", **(headers or {})}
        if body is not None and not isinstance(body, bytes):
            sent["Content-Type"], body = "application/json", json.dumps(body).encode()
        try:
            with contextlib.closing(http.client.HTTPConnection(self.board.address, timeout=PATIENCE)) as connection:
                connection.request(method, path, body, sent)
                answer = connection.getresponse()
                data = answer.read()
        except (OSError, http.client.HTTPException):
            return Answer(0)
        headers = {name.lower(): value for name, value in answer.headers.items()}
        is_json = "json" in answer.headers.get("Content-Type", "")
        return Answer(answer.status, json.loads(data) if is_json and data else None, data, headers)

    def note(
        self,
        act: Act,
        target: str,
        ask: Callable[[], Answer],
        facts: Callable[[Answer], dict[str, Any]] = lambda answer: {},
        request: dict[str, Any] | None = None,
    ) -> Event:
        """Do something, and note it with the facts of its answer; of a refusal with its code."""
        began = self.board.history.now
        answer = ask()
        if answer.ok:
            told = facts(answer)
        else:
            told = {"code": answer.body.get("code", "")} if isinstance(answer.body, dict) else {}
        ended = self.board.history.now
        return self.board.history.note(Event(act, target, answer.status, told, request or {}, began, ended, self.name))
