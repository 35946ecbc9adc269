"""How a child process learns that the one that started it is gone: its stdin, a pipe, closes."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable

__all__ = ["when_parent_is_gone"]

_STDIN = 0


def when_parent_is_gone(act: Callable[[], object], hear: Callable[[bytes], object] = lambda line: None) -> None:
    """Call `act` once, in a thread of its own, when stdin closes, and before that `hear` with every line that arrives.

    The kernel closes the pipe however the parent ends, by SIGKILL too.
    """
    threading.Thread(target=_await_end_of_stdin, args=(act, hear), daemon=True).start()


def _await_end_of_stdin(act: Callable[[], object], hear: Callable[[bytes], object]) -> None:
    # os.read and not sys.stdin: a daemon thread inside a buffered read would abort the interpreter's shutdown.
    rest = b""
    while data := os.read(_STDIN, 4096):
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            hear(line)
    act()
