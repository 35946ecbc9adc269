"""A board without a service, and clients with answers made by hand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from benchmarks.soak.client_calls import Answer, Board, ClientCalls
from benchmarks.soak.request_history import Event, History, read_history

Answers = Callable[[str, str, Any], Answer]


class ScriptedCalls(ClientCalls):
    """A client of a server that is a function."""

    def __init__(self, board: Board, answers: Answers) -> None:
        super().__init__("client", board, 1)
        self.answers = answers

    def ask(self, method: str, path: str, body: Any = None, headers: Any = None, key: str = "") -> Answer:
        return self.answers(method, path, body)

    def rest(self, seconds: float) -> bool:
        return not self.over


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    history = History(tmp_path / "history.jsonl")
    yield Board("127.0.0.1:1", "hgs_key", history)
    history.close()


@pytest.fixture
def scripted(board: Board) -> Callable[[Answers], ScriptedCalls]:
    """Return the function that makes a client of a server that is a function."""
    return lambda answers: ScriptedCalls(board, answers)


@pytest.fixture
def noted(tmp_path: Path, board: Board) -> Callable[[], list[Event]]:
    """Return the function that reads the board's history."""
    return lambda: list(read_history(tmp_path / "history.jsonl"))
