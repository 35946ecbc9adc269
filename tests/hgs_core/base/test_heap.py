from __future__ import annotations

import ctypes
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.heap import trim_heap
from tests.conftest import REPOSITORY


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="only Linux tells what a process holds")
def test_what_a_stage_leaves_in_the_heap_goes_back() -> None:
    if "musl" in sys.version:
        pytest.skip("musl has no such call")

    def resident() -> int:
        return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

    held = [np.ones(1000) for _ in range(20_000)]  # 160 MB in pieces that the heap keeps
    del held[::2]
    full = resident()
    del held
    trim_heap()
    assert full - resident() > 40e6


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "malloc_stats"), reason="the C library is not glibc")
@pytest.mark.parametrize("shared", [True, False])
def test_threads_allocate_from_one_heap(shared: bool) -> None:
    script = """
        import ctypes, sys, threading
        from hgs_core.base.heap import share_heap

        if sys.argv[1] == "True":
            share_heap()
        hold = threading.Barrier(5)
        threads = [threading.Thread(target=lambda: (bytearray(100_000), hold.wait())) for _ in range(4)]
        for thread in threads:
            thread.start()
        hold.wait()
        ctypes.CDLL(None).malloc_stats()
    """
    program = [sys.executable, "-c", textwrap.dedent(script), str(shared)]
    told = subprocess.run(program, cwd=REPOSITORY, capture_output=True, text=True, check=True).stderr
    assert (told.count("Arena") == 1) == shared
