"""The processor's own ceiling."""

from __future__ import annotations

import ctypes

from hgs_core.base.cores import core_count
from hgs_core.native.library import load

__all__ = ["fma_peak"]


def fma_peak(threads: int | None = None, seconds: float = 0.2) -> float:
    """Measure how many floating-point operations per second nothing but fused multiply-adds reaches.

    Args:
        threads: how many of them work at once; default `core_count()`.
        seconds: about how long to measure.

    Returns:
        Operations per second over all threads; a multiply-add counts twice.

    Raises:
        RuntimeError: no compiled library, or the threads could not be started.
    """
    peak = load().hgs_fma_peak
    peak.restype = ctypes.c_double
    operations = float(peak(threads or core_count(), ctypes.c_double(seconds)))
    if not operations:
        raise RuntimeError("the threads of the measurement could not be started")
    return operations
