from __future__ import annotations

import errno
import functools
import subprocess
import sys
from pathlib import Path

import pytest
import torch

from jobs.process import memory_limit as memory
from jobs.process.memory_limit import CURE, out_of_memory, system_kills


def test_python_and_numpy_ran_out() -> None:
    assert out_of_memory(MemoryError()) == f"out of memory: no more could be had; {CURE}"
    assert out_of_memory(MemoryError("3 GiB")) == f"out of memory: 3 GiB; {CURE}"


def test_torch_ran_out() -> None:
    with pytest.raises(RuntimeError) as raised:
        torch.empty(1 << 60, dtype=torch.uint8)
    assert out_of_memory(raised.value).startswith("out of memory: ")


def test_the_gpu_ran_out() -> None:
    assert "CUDA out of memory" in out_of_memory(torch.cuda.OutOfMemoryError("CUDA out of memory. Tried 2 GiB"))


def test_the_system_refused() -> None:
    assert out_of_memory(OSError(errno.ENOMEM, "Cannot allocate memory"))


def test_what_it_was_raised_from_counts() -> None:
    error = ValueError("the picture cannot be read")
    error.__cause__ = MemoryError("3 GiB")
    assert out_of_memory(error)


@pytest.mark.parametrize("error", [ValueError("memory"), RuntimeError("the loss is not a number"), OSError(2, "no")])
def test_other_errors_are_not(error: Exception) -> None:
    assert out_of_memory(error) == ""


def test_the_system_counts_whom_it_kills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "_COUNTERS", tmp_path / "vmstat")
    assert system_kills() is None
    (tmp_path / "vmstat").write_text("pgfault 12\noom_kill 6\nnr_free 3\n")
    assert system_kills() == 6
    (tmp_path / "vmstat").write_text("pgfault 12\n")
    assert system_kills() is None


@pytest.mark.skipif(sys.platform != "linux", reason="no other system does it")
def test_a_process_may_be_limited_and_ends_first() -> None:
    program = (
        "import sys; from pathlib import Path; from jobs.process.memory_limit import limit_memory\n"
        "limit_memory(float(sys.argv[1]) or None)\n"
        "taken = bytearray(1 << 28)\n"
        "print(Path('/proc/self/oom_score_adj').read_text().strip())"
    )
    run = functools.partial(subprocess.run, capture_output=True, text=True, check=False)
    assert run([sys.executable, "-c", program, "0"]).stdout == "500\n"
    assert "MemoryError" in run([sys.executable, "-c", program, str(1 << 28)]).stderr
