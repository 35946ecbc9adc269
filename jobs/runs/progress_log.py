"""The progress log of a job: reports of its stages, thinned out, in a file of its run folder that the API reads.

`progress.jsonl` holds one JSON object a line: `attempt`, `stage`, `done`, `total`, `time` (seconds since the epoch) and
`figures`. A stage is written at most 500 times in one go, whatever it reports. One that goes on from a checkpoint
reports some of its course again: the later word counts.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.progress import Progress
from hgs_core.base.tail import last_lines

__all__ = ["COURSE", "CourseWriter", "Milestone", "read_course", "thinned"]

COURSE = "progress.jsonl"

_POINTS_OF_STAGE = 500
_MOST_BYTES = 4 << 20  # read from the end of the file: 20,000 reports, forty attempts from start to end


@dataclass(frozen=True)
class Milestone:
    """One report that was kept."""

    attempt: int
    stage: str
    done: int
    total: int
    time: float  # seconds since the epoch
    figures: Mapping[str, float]


class CourseWriter:
    """Adds the reports of one attempt at one job to its file."""

    def __init__(self, run: Path, attempt: int) -> None:
        """Write to the run folder `run`."""
        self._file = run / COURSE
        self._attempt = attempt
        self._last: Progress | None = None

    def add(self, progress: Progress) -> None:
        """Write the report down if it is far enough from the last one.

        Raises:
            OSError: the file cannot be written.
        """
        last = self._last
        spacing = -(-progress.total // _POINTS_OF_STAGE)
        again = last is not None and last.stage == progress.stage and last.done <= progress.done
        if again and last is not None and (progress.done - last.done < spacing and progress.done < progress.total):
            return
        if progress == last:
            return
        figures = {name: value for name, value in progress.figures.items() if math.isfinite(value)}
        line = {
            "attempt": self._attempt,
            "stage": progress.stage,
            "done": progress.done,
            "total": progress.total,
            "time": round(time.time(), 3),
            "figures": figures,
        }
        with self._file.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line, separators=(",", ":")) + "\n")
        self._last = progress


def read_course(run: Path) -> list[Milestone]:
    """Return the reports in a run folder, in order; none without a file.

    A damaged line is left out. What was reported twice, because a stage went on from a checkpoint, counts once.

    Raises:
        OSError: the file is there and cannot be read.
    """
    course: list[Milestone] = []
    for line in last_lines(run / COURSE, 1 << 62, _MOST_BYTES).lines:
        milestone = _milestone(line)
        if milestone is None:
            continue
        while course and course[-1].stage == milestone.stage and course[-1].done >= milestone.done:
            course.pop()
        course.append(milestone)
    return course


def thinned(course: Sequence[Milestone], most: int) -> list[Milestone]:
    """Return at most about `most` of the milestones, evenly chosen from each stage with its first and last."""
    if len(course) <= most:
        return list(course)
    stride = math.ceil(len(course) / most)

    def kept(index: int) -> bool:
        ends = {course[other].stage for other in (index - 1, index + 1) if 0 <= other < len(course)}
        return index % stride == 0 or ends != {course[index].stage} or index in (0, len(course) - 1)

    return [milestone for index, milestone in enumerate(course) if kept(index)]


def _milestone(line: str) -> Milestone | None:
    try:
        value: dict[str, Any] = json.loads(line)
        figures = {str(name): float(number) for name, number in value["figures"].items()}
        return Milestone(
            int(value["attempt"]),
            str(value["stage"]),
            int(value["done"]),
            int(value["total"]),
            float(value["time"]),
            {name: number for name, number in figures.items() if math.isfinite(number)},
        )
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError):
        return None
