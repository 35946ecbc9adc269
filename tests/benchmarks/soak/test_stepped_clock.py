from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.soak.stepped_clock import SteppedClock, build_clock, compiler

ASK = """
import datetime, sys, time
for _ in sys.stdin:
    time.sleep(0.01)
    print(time.time(), datetime.datetime.now().timestamp(), time.monotonic(), flush=True)
"""


@pytest.mark.skipif(not compiler(), reason="no C compiler")
def test_a_running_process_sees_the_step_and_its_steady_clock_does_not(tmp_path: Path) -> None:
    clock = SteppedClock(build_clock(tmp_path), tmp_path / "clock")
    asked = subprocess.Popen(
        [sys.executable, "-c", ASK], stdin=-1, stdout=-1, text=True, env={**os.environ, **clock.environment}
    )
    assert asked.stdin is not None
    assert asked.stdout is not None
    for offset in (0.0, 3600.0, -90000.0):
        clock.step_to(offset)
        asked.stdin.write("?\n")
        asked.stdin.flush()
        told, shown, steady = map(float, asked.stdout.readline().split())
        assert abs(told - time.time() - offset) < 300
        assert abs(shown - time.time() - offset) < 300
        assert abs(steady - time.monotonic()) < 300
    asked.communicate()
