"""Signals as requests to a command: a stage saves its checkpoint, and nothing leaves half a file."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any, NoReturn, Self

from hgs_core.base.progress import StageStopped, stop_if_interruptible

__all__ = ["Interrupts", "Terminated", "terminating"]

_LOOK = 0.1  # seconds between two looks while a command waits


class Terminated(BaseException):
    """SIGTERM outside of `Interrupts`: half-written files are removed on the way out, as on Ctrl-C."""


@contextmanager
def terminating() -> Iterator[None]:
    """Let SIGTERM raise `Terminated` inside this context; nothing changes in a thread, to which no signal comes."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated


class Interrupts:
    """Inside this context the first SIGINT or SIGTERM only sets `pending`; the next one acts as usual."""

    def __init__(self) -> None:
        self.pending = False
        self._previous: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        for number in (signal.SIGINT, signal.SIGTERM):
            self._previous[number] = signal.signal(number, self._note)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self._restore()

    def require_none(self) -> None:
        """End the stage if a signal has come.

        Raises:
            StageStopped: one has.
        """
        if self.pending:
            raise StageStopped

    def sleep(self, seconds: float) -> None:
        """Wait, but not beyond the next signal.

        Raises:
            StageStopped: one has come.
        """
        end = time.monotonic() + seconds
        self.require_none()
        while (left := end - time.monotonic()) > 0:
            time.sleep(min(left, _LOOK))
            self.require_none()

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.pending = True
        self._restore()
        # Not print: a handler may run in the middle of another write to the same buffer.
        os.write(2, b"\nsaving and stopping; press Ctrl-C again to stop at once\n")
        stop_if_interruptible()

    def _restore(self) -> None:
        while self._previous:
            number, handler = self._previous.popitem()
            signal.signal(number, handler)
