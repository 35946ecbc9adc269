from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.soak.supervised import SupervisedProcess, stage_processes


def until(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + 120
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def test_a_killed_process_is_started_again_until_it_is_stopped(tmp_path: Path) -> None:
    process = SupervisedProcess("sleeper", ["sleep", "1000"], os.environ, tmp_path / "log")
    first = process.pid
    process.signal(signal.SIGKILL)
    until(lambda: process.pid != first)
    process.stop()
    assert process.starts == 2
    assert not Path("/proc", str(process.pid)).exists()


def test_stages_of_one_home_are_found(tmp_path: Path) -> None:
    sleep = [sys.executable, "-c", "import time; time.sleep(1000)", "jobs.stage", "train"]
    ours, theirs = (subprocess.Popen([*sleep, str(tmp_path / home / "a")]) for home in ("runs", "other"))
    try:
        until(lambda: ours.pid in stage_processes(tmp_path / "runs"))
        assert stage_processes(tmp_path / "runs") == {ours.pid: f"jobs.stage train {tmp_path}/runs/a"}
    finally:
        for process in (ours, theirs):
            process.kill()
            process.wait()
