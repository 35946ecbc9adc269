"""The growth of processes: robust slopes of their curves, without the first part of each life."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from benchmarks.soak.process_curves import Sample

__all__ = ["LIMITS", "Slope", "slope_of", "slopes"]

WARM_UP = 90.0  # seconds of each life
SHORTEST = 40.0  # seconds of a life after that for a slope
APART = 0.5  # share of a life between two samples that are compared
LIMITS: Mapping[str, float] = {"memory": 0.6, "files": 4.0, "threads": 2.0, "connections": 4.0}
"""The largest growth per minute; of memory in MiB."""

_MEASURES: Mapping[str, Callable[[Sample], float]] = {
    "memory": lambda sample: sample.memory,
    "files": lambda sample: sample.files,
    "threads": lambda sample: sample.threads,
    "connections": lambda sample: sample.connections,
}


@dataclass(frozen=True)
class Slope:
    """The growth of a measure of a process per minute; None where no life was long enough."""

    role: str
    measure: str
    per_minute: float | None

    @property
    def too_steep(self) -> bool:
        """Whether it is above its limit."""
        return self.per_minute is not None and self.per_minute > LIMITS[self.measure]


def slope_of(lives: Sequence[Sequence[tuple[float, float]]]) -> float | None:
    """Return the median growth per minute between two moments of a life that lie at least half of it apart.

    A life is its moments in seconds with their values; the median takes no notice of single peaks.
    """
    slopes: list[float] = []
    for life in lives:
        late = [(time, value) for time, value in life if time - life[0][0] >= WARM_UP]
        lasted = late[-1][0] - late[0][0] if late else 0.0
        if lasted < SHORTEST:
            continue
        for time, value in late:
            slopes += [60 * (other - value) / (then - time) for then, other in late if then - time >= APART * lasted]
    return statistics.median(slopes) if slopes else None


def slopes(samples: Mapping[str, Sequence[Sample]]) -> list[Slope]:
    """Return the slopes of all measures of all processes."""
    found = []
    for role, all_lives in samples.items():
        lives: dict[int, list[Sample]] = defaultdict(list)
        for sample in all_lives:
            lives[sample.pid].append(sample)
        for measure, of in _MEASURES.items():
            curves = [[(sample.time, of(sample)) for sample in life] for life in lives.values()]
            found.append(Slope(role, measure, slope_of(curves)))
    return found
