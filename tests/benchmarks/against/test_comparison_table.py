from __future__ import annotations

from benchmarks.against.comparison import Comparison
from benchmarks.against.comparison_table import comparison_text
from hgs_core.bench.raster.stage_times import TrainingTimes


def test_another_checkout_stands_below_this_one() -> None:
    here, other, ratio = (TrainingTimes(*(scale * part for part in (8, 3, 2, 2, 1))) for scale in (1e-3, 2e-3, 1))
    found = Comparison("7@8x9", 1, 3, here, other, ratio, ratio, ratio, {"image": 1e-7}, {"image": 2e-7})
    times, errors = (
        [line.split() for line in part.splitlines()[2:]] for part in comparison_text([found]).split("\n\n")
    )
    assert [row[-5] for row in times[:2]] == ["8.00", "16.00"]
    assert times[2][4:8] == ["fast", "8.00", "(8.00-8.00)", "3.00"]
    assert [row[-1] for row in errors] == ["1.0e-07", "2.0e-07"]
