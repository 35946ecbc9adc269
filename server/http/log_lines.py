"""The server's log on standard error, with limits on repeated messages."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field

__all__ = ["RepeatFilter", "configure_log"]

SECONDS = 60.0
LINES = 5
KINDS = 256


def configure_log() -> None:
    """Write warnings and errors of this process to standard error."""
    handler = logging.StreamHandler()
    handler.addFilter(RepeatFilter())
    logging.basicConfig(
        level=logging.WARNING, format="%(asctime)s %(levelname)s %(name)s: %(message)s", handlers=[handler]
    )


@dataclass
class _Kind:
    since: float
    written: set[str] = field(default_factory=set)
    left_out: int = 0


class RepeatFilter(logging.Filter):
    """Log filter that passes five different lines or one traceback per kind and minute, and counts the rest.

    Messages are of one kind if they share the logger, the text before formatting and, for exceptions, the type and the
    line that raised it.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Measure minutes by `clock`, in seconds."""
        super().__init__()
        self._clock = clock
        self._kinds: dict[tuple[object, ...], _Kind] = {}

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether the record is written."""
        key: tuple[object, ...] = (record.name, str(record.msg).partition("\n")[0])
        most = LINES
        if record.exc_info and record.exc_info[0] is not None:
            trace = record.exc_info[2]
            while trace is not None and trace.tb_next is not None:
                trace = trace.tb_next
            key += (record.exc_info[0], trace and (trace.tb_frame.f_code, trace.tb_lineno))
            most = 1
        now, text = self._clock(), record.getMessage()
        kind = self._kinds.get(key)
        if kind is None or now - kind.since >= SECONDS:
            # Kinds are few, except for messages formatted by a library.
            if len(self._kinds) >= KINDS:
                del self._kinds[next(iter(self._kinds))]
            if kind is not None and kind.left_out:
                record.msg, record.args = f"{text} ({kind.left_out} more like this since the last)", None
            kind = self._kinds[key] = _Kind(now)
        if text in kind.written or len(kind.written) == most:
            kind.left_out += 1
            return False
        kind.written.add(text)
        return True
