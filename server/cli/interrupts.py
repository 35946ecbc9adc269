"""Ctrl-C as a wish that a stage can obey: it saves what it can resume from and then ends."""

from __future__ import annotations

import os
import signal
from types import FrameType, TracebackType
from typing import Any, Self

__all__ = ["Interrupts"]


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

    def _note(self, number: int, frame: FrameType | None) -> None:
        self.pending = True
        self._restore()
        # Not print: a handler may run in the middle of another write to the same buffer.
        os.write(2, b"\nsaving and stopping; press Ctrl-C again to stop at once\n")

    def _restore(self) -> None:
        while self._previous:
            number, handler = self._previous.popitem()
            signal.signal(number, handler)
