"""Whether a stage hangs: it says nothing and uses no processor time either, or it says nothing for very long.

A stage may compute for long without a word (structure from motion, the search for a coarseness): then it is busy. One
that was stopped, is dead-locked or waits for a dead file server is not; one that spins for ever looks busy, but not
that long. The processor time is read from outside, since
a library that holds the interpreter's lock for minutes would keep a heartbeat of the stage's own from being sent.
"""

from __future__ import annotations

import math

from jobs.process.process_tree import ProcessTree

__all__ = ["Silence"]

LOOKS = 10  # looks during the longest allowed silence
BUSY_SHARE = 0.003  # share of one processor; watching threads use less


class Silence:
    """Counts how long the processes of a stage have been silent and idle, and how long silent.

    Time counts only while somebody looks, so that a machine that slept does not take its stages for hung.
    """

    def __init__(self, processes: ProcessTree, longest: float, longest_busy: float = math.inf) -> None:
        """Watch `processes`; `longest` is the silence in seconds after which it counts as hung.

        `longest_busy` is the same for one that computes.
        """
        self.interval = longest / LOOKS
        self.over = False
        self._processes = processes
        self._enough = BUSY_SHARE * longest
        self._looks = 0
        self._silent_looks = 0
        self._most_silent_looks = longest_busy / self.interval
        self._seconds = _cpu_seconds(processes)

    def broken(self) -> None:
        """Note that the stage has said something."""
        self._looks = self._silent_looks = 0

    def look(self) -> None:
        """Look once; to be called every `interval` seconds."""
        self._silent_looks += 1
        self.over = self.over or self._silent_looks >= self._most_silent_looks
        seconds = _cpu_seconds(self._processes)
        if seconds is None:  # not Linux: nobody can tell, and a busy stage must not be killed
            return
        if self._seconds is None or abs(seconds - self._seconds) > self._enough:
            self._seconds, self._looks = seconds, 0
        else:
            self._looks += 1
        self.over = self.over or self._looks >= LOOKS


def _cpu_seconds(processes: ProcessTree) -> float | None:
    """Return the processor time of the living processes, in seconds; None where there are none or nobody can tell."""
    found = processes.look()
    return sum(process.seconds for process in found) if found else None
