"""Processes of a service that are started again when they end, as systemd does."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

__all__ = ["SupervisedProcess", "stage_processes"]

PAUSE = 0.5  # seconds before a new start


class SupervisedProcess:
    """A process by its role; another takes its place until it is stopped for good."""

    def __init__(self, role: str, command: Sequence[str], environment: Mapping[str, str], log: Path) -> None:
        """Start it."""
        self.role = role
        self.starts = 0
        self.began = 0.0  # seconds of the monotonic clock, of the present process
        self._command, self._environment, self._log = command, environment, log
        self._over = threading.Event()
        self._process = self._start()
        self._thread = threading.Thread(target=self._supervise, name=role, daemon=True)
        self._thread.start()

    @property
    def pid(self) -> int:
        """The number of the present process."""
        return self._process.pid

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to the present process."""
        self._process.send_signal(number)

    def stop(self) -> None:
        """Kill it for good."""
        self._over.set()
        self._process.kill()
        self._thread.join()
        self._process.kill()
        self._process.wait()

    def _start(self) -> subprocess.Popen[bytes]:
        self.starts += 1
        self.began = time.monotonic()
        with self._log.open("ab") as log:
            return subprocess.Popen(
                self._command, env=self._environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log
            )

    def _supervise(self) -> None:
        while not self._over.is_set():
            self._process.wait()
            if not self._over.wait(PAUSE):
                self._process = self._start()


def stage_processes(runs: Path) -> dict[int, str]:
    """Return the processes of stages that work in a folder of runs, with their command lines."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if "jobs.stage" in words and any(Path(word).parent == runs for word in words):
            found[int(process.name)] = " ".join(words[words.index("jobs.stage") :]).strip()
    return {pid: line for pid, line in found.items() if pid != os.getpid()}
