from __future__ import annotations

import pytest

from hgs_core.base.progress import Progress
from jobs.process.stage_pace import StagePace


def test_a_stage_ends_as_fast_as_it_went_on() -> None:
    pace = StagePace()
    pace.ends(Progress("train", 0, 100), 1000.0)
    assert pace.ends(Progress("train", 20, 100), 1010.0) == pytest.approx(1050.0)  # 2 a second, 80 are left


def test_what_was_done_before_a_checkpoint_does_not_count() -> None:
    pace = StagePace()
    pace.ends(Progress("train", 90, 100), 1000.0)
    assert pace.ends(Progress("train", 92, 100), 1010.0) == pytest.approx(1050.0)


def test_only_the_last_five_minutes_count() -> None:
    pace = StagePace()
    for second in range(0, 1000, 10):
        pace.ends(Progress("train", second, 10_000), float(second))
    for second in range(1000, 1400, 10):  # ten times slower
        ends = pace.ends(Progress("train", 1000 + (second - 1000) // 10, 10_000), float(second))
    assert ends == pytest.approx(1390 + (10_000 - 1039) * 10, rel=0.01)


@pytest.mark.parametrize(
    ("reports"),
    [
        [("train", 0, 0.0)],
        [("train", 0, 0.0), ("train", 2, 4.9)],  # too early to tell
        [("train", 5, 0.0), ("train", 5, 60.0)],  # it stands still
        [("train", 0, 0.0), ("encode", 2, 60.0)],
        [("train", 50, 0.0), ("train", 10, 60.0)],  # begun again
    ],
)
def test_nobody_knows(reports: list[tuple[str, int, float]]) -> None:
    pace = StagePace()
    assert [pace.ends(Progress(stage, done, 100), now) for stage, done, now in reports][-1] == 0.0
