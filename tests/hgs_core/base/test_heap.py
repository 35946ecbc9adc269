from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.heap import trim_heap


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
