"""The heap of a process: one for all threads, and memory that goes back to the system between stages."""

from __future__ import annotations

import ctypes
import gc

__all__ = ["return_free_memory", "share_heap", "trim_heap"]

_M_ARENA_MAX = -8  # number of glibc's parameter (malloc.h)


def share_heap() -> None:
    """Let all threads allocate from one heap, where the C library is glibc; call it before any other thread starts.

    By default every thread has a heap of its own. Each keeps the holes that its large arrays leave behind, which no
    other thread can fill. Threads that compute on large arrays seldom wait for the one heap.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        mallopt(_M_ARENA_MAX, 1)


def trim_heap() -> None:
    """Collect garbage and return free memory to the system, between stages."""
    gc.collect()
    return_free_memory()


def return_free_memory() -> None:
    """Return free memory of the heap to the system, where the C library (glibc) can.

    Large arrays leave a heap full of holes behind, which the next ones would only partly fill.
    """
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
    if trim is not None:
        trim(0)
