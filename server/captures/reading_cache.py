"""Cache of the results of capture readers: no capture is opened again until one of its files changes."""

from __future__ import annotations

import hashlib
import os
import threading
import time
from collections import OrderedDict
from pathlib import Path
from typing import Generic, TypeVar

__all__ = ["KEPT_SECONDS", "ReadingCache", "files_mark"]

KEPT_SECONDS = 600.0  # time to remember that a capture ended its reader: the machine may have been at fault

_DEEPEST = 6  # levels below a capture

Found = TypeVar("Found")


class ReadingCache(Generic[Found]):
    """Keeps the results of readers by keys with their files' marks; safe to use from several threads."""

    def __init__(self, most: int) -> None:
        """Keep results of the size `most` together; the earliest go first."""
        self._most, self._size = most, 0
        self._kept: OrderedDict[str, tuple[Found, int, float]] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: str) -> Found | None:
        """Return the unexpired result of a key, or None."""
        with self._lock:
            found, _, until = self._kept.get(key, (None, 0, 0.0))
        return found if time.monotonic() <= until else None

    def keep(self, key: str, found: Found, size: int = 1, seconds: float = float("inf")) -> None:
        """Keep a result for so many seconds."""
        with self._lock:
            self._size += size - self._kept.pop(key, (found, 0, 0.0))[1]
            self._kept[key] = found, size, time.monotonic() + seconds
            while self._size > self._most:
                self._size -= self._kept.popitem(last=False)[1][1]


def files_mark(path: Path) -> str:
    """Return a mark that changes with the names, sizes and times of the files at and below a path."""
    found: list[tuple[str, int, int]] = []
    waiting = [(str(path), 0)]
    while waiting:
        here, depth = waiting.pop()
        try:
            status = Path(here).stat()
            found.append((here, status.st_size, status.st_mtime_ns))
            with os.scandir(here) as entries:
                waiting += [(entry.path, depth + 1) for entry in entries if depth < _DEEPEST]
        except OSError:  # a file, or an unreadable folder
            continue
    return hashlib.sha256(repr(sorted(found)).encode()).hexdigest()
