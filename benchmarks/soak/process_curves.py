"""Curves of processes: memory, descriptors, threads and connections by the second, and folders' sizes (Linux)."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Curves", "Sample", "sample_of"]

INTERVAL = 1.0  # seconds
FOLDER_INTERVAL = 10.0
_PAGE = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True)
class Sample:
    """A process at a moment; the same pid is the same life."""

    time: float  # seconds since the start of the soak
    pid: int
    memory: float  # MiB that it holds
    files: int
    threads: int
    connections: int


def sample_of(pid: int, time: float) -> Sample | None:
    """Return the present sample of a process; None if it is gone, or has not begun to do its work."""
    process = Path("/proc", str(pid))
    try:
        pages = int((process / "statm").read_text().split()[1])
        links = [_link(entry) for entry in (process / "fd").iterdir()]
        threads = len(list((process / "task").iterdir()))
    except OSError:
        return None
    if pages == 0:
        return None
    sockets = sum(link.startswith("socket:") for link in links)
    return Sample(time, pid, pages * _PAGE / 2**20, len(links), threads, sockets)


def _link(entry: Path) -> str:
    try:
        return str(entry.readlink())
    except OSError:  # closed meanwhile
        return ""


class Curves(threading.Thread):
    """Looks at processes and folders until it is stopped."""

    def __init__(self, pids: Callable[[], Mapping[str, int]], folders: Mapping[str, Path], now: Callable[[], float]):
        """Look at `pids` by role, and at `folders` by name; `now` is the clock."""
        super().__init__(daemon=True)
        self._pids, self._folders, self._now = pids, folders, now
        self._over = threading.Event()
        self.samples: dict[str, list[Sample]] = {}
        self.disk: dict[str, list[tuple[float, float]]] = {name: [] for name in folders}  # seconds, MiB

    def run(self) -> None:
        """Look."""
        folders_at = 0.0
        while not self._over.wait(INTERVAL):
            for role, pid in self._pids().items():
                if (sample := sample_of(pid, self._now())) is not None:
                    self.samples.setdefault(role, []).append(sample)
            if self._now() >= folders_at:
                folders_at = self._now() + FOLDER_INTERVAL
                for name, folder in self._folders.items():
                    self.disk[name].append((self._now(), _size(folder)))

    def stop(self) -> None:
        """End."""
        self._over.set()
        self.join()


def _size(folder: Path) -> float:
    total = 0
    for here, _, files in os.walk(folder):
        for file in files:
            try:
                total += Path(here, file).stat().st_size
            except OSError:  # removed meanwhile
                continue
    return total / 2**20
