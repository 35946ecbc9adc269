"""The remaining time of a whole training, from its predicted cost and the pace of its reports so far."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from hgs_core.base.progress import Progress
from hgs_core.runs.run_folder import RunFolder
from hgs_core.runs.training_need import TrainingNeed

__all__ = ["RemainingTime"]

_WINDOW = 300.0  # seconds of reports that tell the present stage's pace: the load of a machine changes
_TRUSTED = 10.0  # seconds that the prediction counts for, beside those measured
_SHORTEST = 5.0  # seconds of reports before a stage without a prediction has a pace
_TRAIN = "train"


class RemainingTime:
    """The remaining time after each report, of one run.

    The pace is the measured time over the predicted time of the same work. The present stage goes on at its own pace,
    the later ones at that of all work so far. A stage without a prediction goes on as its own reports do.
    """

    def __init__(self, need: TrainingNeed | None) -> None:
        self._expected: Mapping[str, float] = {} if need is None else need.seconds()
        self._course: Sequence[float] = () if need is None else (0.0, *need.course)
        self._stage = ""
        self._reports: deque[tuple[float, float]] = deque()  # (time, share of the stage's cost that is over)
        self._measured = self._predicted = 0.0  # seconds of the stages before

    @property
    def predicted(self) -> bool:
        """Whether there is a prediction."""
        return bool(self._expected)

    @classmethod
    def of_run(cls, run: Path) -> RemainingTime:
        """Return that of a run; its need is known once its cameras are."""
        return cls(TrainingNeed.load(RunFolder(run).need))

    def after(self, progress: Progress, now: float) -> float | None:
        """Take in a report made at `now`, seconds of any clock, and return the seconds that remain; None: unknown."""
        over = self._over(progress)
        if progress.stage != self._stage or (self._reports and over < self._reports[-1][1]):
            self._measured, self._predicted = self._known()
            self._stage = progress.stage
            self._reports.clear()
        self._reports.append((now, over))
        while now - self._reports[0][0] > _WINDOW and len(self._reports) > 2:
            self._reports.popleft()
        return self._remaining(progress.stage, 1 - over)

    def _remaining(self, stage: str, left: float) -> float | None:
        own = self._expected.get(stage)
        if own is None:
            spent, covered = self._spent(), self._reports[-1][1] - self._reports[0][1]
            if spent < _SHORTEST or covered <= 0:
                return None
            return left * spent / covered + sum(self._expected.values()) * self._pace()
        stages = list(self._expected)
        later = sum(self._expected[name] for name in stages[stages.index(stage) + 1 :])
        pace = self._pace()
        here = (self._spent() + _TRUSTED * pace) / (self._covered(stage) + _TRUSTED)
        return left * own * here + later * pace

    def _pace(self) -> float:
        measured, predicted = self._known()
        return (measured + _TRUSTED) / (predicted + _TRUSTED)

    def _known(self) -> tuple[float, float]:
        """Return the measured and predicted seconds of all work so far that there is a prediction of."""
        spent = self._spent() if self._stage in self._expected else 0.0
        return self._measured + spent, self._predicted + self._covered(self._stage)

    def _spent(self) -> float:
        return self._reports[-1][0] - self._reports[0][0] if self._reports else 0.0

    def _covered(self, stage: str) -> float:
        """Return the predicted seconds of the work between the stage's first and last report that count."""
        covered = self._reports[-1][1] - self._reports[0][1] if self._reports else 0.0
        return covered * self._expected.get(stage, 0.0)

    def _over(self, progress: Progress) -> float:
        share = min(1.0, progress.done / max(1, progress.total))
        if progress.stage != _TRAIN or len(self._course) < 2:
            return share
        return float(np.interp(share, np.linspace(0, 1, len(self._course)), self._course))
