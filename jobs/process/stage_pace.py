"""When a stage will probably end, from how fast it was lately."""

from __future__ import annotations

from collections import deque

from hgs_core.base.progress import Progress

__all__ = ["StagePace"]

WINDOW = 300.0  # seconds that count as lately: training slows down as splats are added
SHORTEST = 5.0  # seconds that must have been seen before anything is said


class StagePace:
    """The reports of one stage process; after a checkpoint it begins at its first report."""

    def __init__(self) -> None:
        self._stage = ""
        self._seen: deque[tuple[float, int]] = deque()  # (time, done)

    def ends(self, progress: Progress, now: float) -> float:
        """Take in a report made at `now`, and return when the stage will end, on the same clock; 0 if nobody knows."""
        if progress.stage != self._stage or (self._seen and progress.done < self._seen[-1][1]):
            self._stage = progress.stage
            self._seen.clear()
        self._seen.append((now, progress.done))
        while now - self._seen[0][0] > WINDOW and len(self._seen) > 2:
            self._seen.popleft()
        began, first = self._seen[0]
        seconds, done = now - began, progress.done - first
        if seconds < SHORTEST or done <= 0 or progress.done > progress.total:
            return 0.0
        return now + (progress.total - progress.done) * seconds / done
