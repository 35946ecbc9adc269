"""How a child process learns that the one that started it is gone: its stdin, a pipe, closes."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable

from jobs.process.lasting_thread import lasting_thread

__all__ = ["when_parent_is_gone"]

_STDIN = 0


def when_parent_is_gone(act: Callable[[], object], hear: Callable[[bytes], object] = lambda line: None) -> None:
    """Call `act` once, in a thread of its own, when stdin closes, and before that `hear` with every line that arrives.

    The kernel closes the pipe however the parent ends, by SIGKILL too.
    """
    lasting_thread("parent", lambda: _await_end_of_stdin(act, hear)).start()


def _await_end_of_stdin(act: Callable[[], object], hear: Callable[[bytes], object]) -> None:
    # os.read and not sys.stdin: a daemon thread inside a buffered read would abort the interpreter's shutdown.
    rest = b""
    while data := _read():
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            hear(line)
    act()


def _read() -> bytes:
    """Return the next bytes, b"" at the end; a closed or broken stdin has ended."""
    try:
        return os.read(_STDIN, 4096)
    except OSError as error:
        if error.errno in (errno.EBADF, errno.EIO, errno.EINVAL, errno.ENXIO):
            return b""
        raise
