"""Giving memory back to the system between the stages of a long process."""

from __future__ import annotations

import ctypes
import gc

__all__ = ["trim_heap"]


def trim_heap() -> None:
    """Return unused memory of the heap to the system, where the C library (glibc) can.

    A stage's arrays leave a heap full of holes behind, which the next stage's would only partly fill.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
