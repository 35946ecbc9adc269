"""How much memory a stage may take, and whether it ran out of it: it says so itself, or the system has killed it."""

from __future__ import annotations

import contextlib
import errno
import resource
from pathlib import Path

from jobs.home.passing_faults import chain, one_line

__all__ = ["CURE", "limit_memory", "out_of_memory", "system_kills"]

_GOES_FIRST = 500  # out of 1000: when memory is short, the system ends a stage first
_COUNTERS = Path("/proc/vmstat")
CURE = "give it more (a larger machine, or a higher HGS_STAGE_MEMORY), or --set capture.downscale=2"


def limit_memory(most: float | None) -> None:
    """Let this process and those that it starts each take so many bytes at most, if that is given; Linux alone does so.

    Without a limit, too, the system ends this process before workers, servers and databases when it lacks memory.
    """
    with contextlib.suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text(str(_GOES_FIRST))
    if most is not None:
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        limit = int(most) if hard == resource.RLIM_INFINITY else min(int(most), hard)
        resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))


def out_of_memory(error: BaseException) -> str:
    """Return in one line that an error means too little memory, of the machine or the GPU, and the cure; else ""."""
    for cause in chain(error):
        named = type(cause).__name__ == "OutOfMemoryError"  # torch's, without importing torch
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
