"""Threads on which others rely as long as the process lives: one that dies is started again, and the log says so."""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable

__all__ = ["lasting_thread"]

PAUSE = 2.0  # seconds before a thread that has died runs again

log = logging.getLogger(__name__)


def lasting_thread(name: str, work: Callable[[], object]) -> threading.Thread:
    """Return a thread, not started yet, that ends when `work` returns, and repeats it after any exception."""

    def run() -> None:
        pause = threading.Event()
        while True:
            try:
                work()
            except BaseException:
                log.exception("the thread %r has died; it goes on in %g s", name, PAUSE)
            else:
                return
            with contextlib.suppress(BaseException):  # waiting may fail, too, as where memory is short
                pause.wait(PAUSE)

    return threading.Thread(target=run, name=name, daemon=True)
