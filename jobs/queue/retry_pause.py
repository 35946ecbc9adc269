"""The pause before a job goes on after a passing fault: doubled each time, up to two hours."""

from __future__ import annotations

__all__ = ["retry_pause"]

FIRST_PAUSE, LONGEST_PAUSE = 5.0, 7200.0  # seconds


def retry_pause(waits: int) -> float:
    """Return the seconds that a job is put off for by a passing fault, after `waits` such pauses in a row."""
    return min(FIRST_PAUSE * 2.0**waits, LONGEST_PAUSE)
