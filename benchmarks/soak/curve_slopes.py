"""The growth of processes: robust slopes of their curves, which neither a warm-up nor a step after a fault raises."""

from __future__ import annotations

import statistics
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from benchmarks.soak.process_curves import Sample

__all__ = ["LIMITS", "Slope", "slope_of", "slopes"]

WARM_UP = 90.0  # seconds of each life
PARTS = 3  # a leak grows in each part of a life; a step only in one
SHORTEST = 75.0  # seconds of a life after its warm-up
SHORTEST_MEMORY = 150.0  # the same; the first viewers of scenes fill caches
LIMITS: Mapping[str, float] = {"memory": 1.0, "files": 4.0, "threads": 2.0, "connections": 4.0}
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


def slope_of(lives: Sequence[Sequence[tuple[float, float]]], shortest: float = SHORTEST) -> float | None:
    """Return the growth per minute of the longest life, after its warm-up: the smallest of its parts' median slopes.

    A life is its moments in seconds with their values. Two moments count that lie at least half a part apart.
    None where no life lasted for `shortest` seconds after its warm-up.
    """
    late = [[(time, value) for time, value in life if time - life[0][0] >= WARM_UP] for life in lives]
    longest = max(late, key=lambda life: life[-1][0] - life[0][0] if life else 0.0, default=[])
    lasts = (longest[-1][0] - longest[0][0] if longest else 0.0) / PARTS
    if lasts * PARTS < shortest:
        return None
    found = []
    for part in range(PARTS):
        begin = longest[0][0] + part * lasts
        points = [(time, value) for time, value in longest if begin <= time <= begin + lasts]
        found.append([(b - a) / (then - time) for time, a in points for then, b in points if then - time >= lasts / 2])
    return min(60 * statistics.median(part) if part else 0.0 for part in found)


def slopes(samples: Mapping[str, Sequence[Sample]]) -> list[Slope]:
    """Return the slopes of all measures of all processes."""
    found = []
    for role, all_lives in samples.items():
        lives: dict[int, list[Sample]] = defaultdict(list)
        for sample in all_lives:
            lives[sample.pid].append(sample)
        for measure, of in _MEASURES.items():
            curves = [[(sample.time, of(sample)) for sample in life] for life in lives.values()]
            shortest = SHORTEST_MEMORY if measure == "memory" else SHORTEST
            found.append(Slope(role, measure, slope_of(curves, shortest)))
    return found
