"""The workers that `hgs serve` runs beside the API: children that are started again when they die."""

from __future__ import annotations

import logging
import subprocess
import threading
from types import TracebackType
from typing import Self

from jobs.home.home import Home
from jobs.process.lasting_thread import lasting_thread
from jobs.worker import start_worker

__all__ = ["WorkerProcesses"]

log = logging.getLogger("hgs.server")

LOOK_SECONDS = 1.0
LONGEST_WAIT = 60.0  # seconds before a worker that dies again and again is started anew
STOP_SECONDS = 15.0


class WorkerProcesses:
    """Keeps `count` workers running inside this context, and ends them in order when it is left."""

    def __init__(self, home: Home, count: int) -> None:
        self._home = home
        self._children: list[subprocess.Popen[bytes]] = []
        self._count = count
        self._stop = threading.Event()
        self._thread = lasting_thread("workers", self._watch)

    def __enter__(self) -> Self:
        self._children = [start_worker(self._home) for _ in range(self._count)]
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()
        for child in self._children:
            if child.stdin is not None:
                child.stdin.close()  # a worker stops when its stdin closes
        for child in self._children:
            try:
                child.wait(STOP_SECONDS)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()

    def _watch(self) -> None:
        wait = LOOK_SECONDS
        while not self._stop.wait(wait):
            dead = [index for index, child in enumerate(self._children) if child.poll() is not None]
            # Waiting longer each time keeps a worker that cannot start from filling the log.
            wait = min(2 * wait, LONGEST_WAIT) if dead else LOOK_SECONDS
            for index in dead:
                log.warning("a worker ended with status %s; starting another", self._children[index].returncode)
                self._children[index] = start_worker(self._home)
