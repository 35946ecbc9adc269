from __future__ import annotations

import ctypes
from types import SimpleNamespace
from typing import Any

import pytest

from hgs_core.native import library, peak


class Kernel:
    """A stand-in for the library's measurement: it notes its arguments and returns a figure."""

    restype: Any = None

    def __init__(self, figure: float) -> None:
        self.figure, self.asked = figure, []

    def __call__(self, threads: int, seconds: ctypes.c_double) -> float:
        self.asked.append((threads, seconds.value))
        return self.figure


@pytest.mark.parametrize(("threads", "asked"), [(None, 3), (2, 2)])
def test_the_threads_are_those_given_or_the_programs(
    monkeypatch: pytest.MonkeyPatch, threads: int | None, asked: int
) -> None:
    kernel = Kernel(1e9)
    monkeypatch.setattr(peak, "load", lambda: SimpleNamespace(hgs_fma_peak=kernel))
    monkeypatch.setenv("HGS_THREADS", "3")
    assert peak.fma_peak(threads, 0.01) == 1e9
    assert kernel.asked == [(asked, 0.01)]
    assert kernel.restype is ctypes.c_double


def test_threads_that_cannot_be_started_are_an_error_and_no_peak(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peak, "load", lambda: SimpleNamespace(hgs_fma_peak=Kernel(0.0)))
    with pytest.raises(RuntimeError, match="could not be started"):
        peak.fma_peak()


@pytest.mark.skipif(not library.available(), reason="hgs was built without its C++ kernels")
def test_the_kernel_gives_operations_and_not_giga_operations_per_second() -> None:
    assert peak.fma_peak(1, 1e-3) > 1e6  # slower than any processor that runs this
