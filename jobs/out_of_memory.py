"""Whether it was memory that a stage ran out of: it says so itself, or the system has killed it."""

from __future__ import annotations

import errno
from pathlib import Path

from jobs.transient_faults import chain, one_line

__all__ = ["CURE", "out_of_memory", "system_kills"]

_COUNTERS = Path("/proc/vmstat")
CURE = "give it a machine with more, or --set capture.downscale=2"


def out_of_memory(error: BaseException) -> str:
    """Return in one line that an error means too little memory, of the machine or the GPU, and the cure; else ""."""
    for cause in chain(error):
        named = type(cause).__name__ == "OutOfMemoryError"  # of torch, which is not imported here
        refused = isinstance(cause, RuntimeError) and "can't allocate memory" in str(cause)  # torch's, on the CPU
        if isinstance(cause, MemoryError) or named or refused or getattr(cause, "errno", None) == errno.ENOMEM:
            return f"out of memory: {one_line(cause) or 'no more could be had'}; {CURE}"
    return ""


def system_kills() -> int | None:
    """Return how many processes the system has killed for lack of memory since it started; None if it does not say."""
    try:
        lines = _COUNTERS.read_text().splitlines()
    except OSError:
        return None
    return next((int(line.split()[1]) for line in lines if line.startswith("oom_kill ")), None)
