from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from jobs.process import stage_silence
from jobs.process.process_tree import ProcessTree
from jobs.process.stage_silence import LOOKS, Silence

TREE = ProcessTree(1)


@pytest.fixture
def seconds(monkeypatch: pytest.MonkeyPatch) -> list[float | None]:
    """The processor time that a stage is said to have used: the last element."""
    used: list[float | None] = [0.0]
    monkeypatch.setattr(stage_silence, "_cpu_seconds", lambda processes: used[-1])
    return used


def looks_until_over(silence: Silence) -> int:
    for count in range(1, 100):
        silence.look()
        if silence.over:
            return count
    return 0


def test_idle_and_silent_is_over_after_the_longest_silence(seconds: list[float | None]) -> None:
    silence = Silence(TREE, 300)
    assert silence.interval * looks_until_over(silence) == 300


def test_a_word_begins_it_anew(seconds: list[float | None]) -> None:
    silence = Silence(TREE, 300)
    for _ in range(LOOKS - 1):
        silence.look()
    silence.broken()
    assert looks_until_over(silence) == LOOKS


def test_work_begins_it_anew_and_idling_does_not(seconds: list[float | None]) -> None:
    silence = Silence(TREE, 300)
    for _ in range(3 * LOOKS):  # a hundredth of a processor
        seconds.append((seconds[-1] or 0) + 0.3)
        silence.look()
    assert not silence.over
    for _ in range(LOOKS + 5):
        seconds.append((seconds[-1] or 0) + 0.003)
        silence.look()
    assert silence.over


def test_where_nobody_can_tell_no_stage_is_taken_for_hung(seconds: list[float | None]) -> None:
    seconds.append(None)
    assert looks_until_over(Silence(TREE, 300)) == 0


def test_without_a_word_for_very_long_a_busy_stage_is_over_too(seconds: list[float | None]) -> None:
    silence = Silence(TREE, 300, 900)
    looks = 0
    while not silence.over:
        seconds.append((seconds[-1] or 0) + 30)
        silence.look()
        looks += 1
    assert looks * silence.interval == 900
    silence = Silence(TREE, 300, 900)
    for _ in range(100):
        seconds.append((seconds[-1] or 0) + 30)
        silence.broken()
        silence.look()
    assert not silence.over


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="the system has no /proc")
def test_the_time_of_all_processes_of_a_stage_counts() -> None:
    # A little longer than is asked for below: the system counts in ticks of 10 ms.
    busy = "import time\nwhile time.process_time() < 0.35: pass\nprint('done', flush=True); input()"
    parent = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {busy!r}])"
    with subprocess.Popen(
        [sys.executable, "-c", parent], stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"done\n"
        used = stage_silence._cpu_seconds(ProcessTree(process.pid))
    assert used is not None
    assert used >= 0.3
