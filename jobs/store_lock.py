"""Publishing and collecting exclude each other: who publishes does not store a chunk again that is there already."""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from hgs_core.base.errors import InputError

__all__ = ["StoreLock"]

_POLL = 0.2  # seconds


class StoreLock:
    """A file lock, which the kernel drops with the process, however that ends."""

    def __init__(self, path: Path) -> None:
        """Lock `path`, which is made where it is missing."""
        self._path = path

    @contextmanager
    def publishing(self, waiting: Callable[[], object]) -> Iterator[None]:
        """Keep collectors out; `waiting` is called again and again while one is at work."""
        with self._held(fcntl.LOCK_SH, waiting):
            yield

    @contextmanager
    def collecting(self, patience: float) -> Iterator[None]:
        """Keep publishers and other collectors out.

        Raises:
            InputError: scenes have been published for the `patience`, in seconds, without a pause.
        """
        deadline = time.monotonic() + patience

        def wait() -> None:
            if time.monotonic() >= deadline:
                raise InputError("the store", "a scene is being published, or collected", "try again later")

        with self._held(fcntl.LOCK_EX, wait):
            yield

    @contextmanager
    def _held(self, kind: int, waiting: Callable[[], object]) -> Iterator[None]:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        file = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            while True:
                try:
                    fcntl.flock(file, kind | fcntl.LOCK_NB)
                    break
                except BlockingIOError:
                    waiting()
                    time.sleep(_POLL)
            yield
        finally:
            os.close(file)
