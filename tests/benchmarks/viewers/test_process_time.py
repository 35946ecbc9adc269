"""Processor time of children, against a /proc that is written by hand and against a real child."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from benchmarks.viewers.process_time import descendants_cpu_seconds


def _process(proc: Path, pid: int, parent: int, user: int, system: int, name: str = "a") -> None:
    (proc / str(pid)).mkdir()
    before = f"{pid} ({name}) S {parent} " + "0 " * 9
    (proc / str(pid) / "stat").write_text(f"{before}{user} {system} 0 0 20 0")


def test_children_and_theirs_count_and_nobody_else(tmp_path: Path) -> None:
    _process(tmp_path, 10, 1, 100_000, 0)
    _process(tmp_path, 11, 10, 300, 50, name="tab) (S 1")
    _process(tmp_path, 12, 11, 40, 10)
    _process(tmp_path, 13, 1, 70_000, 0)
    (tmp_path / "14").mkdir()  # has ended: it has no stat any more
    (tmp_path / "meminfo").write_text("")
    assert descendants_cpu_seconds(10, tmp_path) == 400 / os.sysconf("SC_CLK_TCK")


def test_what_a_child_computes_counts() -> None:
    script = "import time\nwhile time.process_time() < 0.3: pass\nprint('done', flush=True)\ninput()"
    before = descendants_cpu_seconds()
    with subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as child:
        assert child.stdout is not None
        child.stdout.readline()
        used = descendants_cpu_seconds() - before
        child.communicate("\n")
    assert used >= 0.25
