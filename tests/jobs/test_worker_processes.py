from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

from jobs import worker_processes
from jobs.home.home import Home
from jobs.process import lasting_thread
from jobs.worker_processes import WorkerProcesses


@pytest.fixture
def children(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[bytes]]:
    """Put children in the place of workers that do nothing until their stdin closes; return those started so far."""
    started: list[subprocess.Popen[bytes]] = []

    def start_worker(home: Home) -> subprocess.Popen[bytes]:
        started.append(subprocess.Popen([sys.executable, "-c", "import sys; sys.stdin.read()"], stdin=subprocess.PIPE))
        return started[-1]

    monkeypatch.setattr(worker_processes, "start_worker", start_worker)
    monkeypatch.setattr(worker_processes, "LOOK_SECONDS", 0.05)
    return started


def test_workers_end_with_the_context(tmp_path: Path, children: list[subprocess.Popen[bytes]]) -> None:
    with WorkerProcesses(Home.at(tmp_path), 2):
        assert len(children) == 2
    assert [child.returncode for child in children] == [0, 0]


def test_worker_that_dies_is_replaced(tmp_path: Path, children: list[subprocess.Popen[bytes]]) -> None:
    with WorkerProcesses(Home.at(tmp_path), 1):
        children[0].kill()
        deadline = time.monotonic() + 60
        while len(children) < 2:
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert children[1].returncode == 0
    if children[0].stdin is not None:
        children[0].stdin.close()


def test_workers_are_replaced_also_after_one_could_not_be_started(
    tmp_path: Path, children: list[subprocess.Popen[bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    start, refused = worker_processes.start_worker, [OSError("Resource temporarily unavailable")]

    def start_sometimes(home: Home) -> subprocess.Popen[bytes]:
        if children and refused:
            raise refused.pop()
        return start(home)

    monkeypatch.setattr(worker_processes, "start_worker", start_sometimes)
    monkeypatch.setattr(lasting_thread, "PAUSE", 0.01)
    with WorkerProcesses(Home.at(tmp_path), 1):
        children[0].kill()
        deadline = time.monotonic() + 60
        while len(children) < 2:
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert not refused
    if children[0].stdin is not None:
        children[0].stdin.close()
