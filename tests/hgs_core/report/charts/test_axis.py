from __future__ import annotations

import math

import pytest

from hgs_core.report.charts.axis import linear_axis


@pytest.mark.parametrize(
    ("low", "high", "ticks"),
    [
        (26.6, 27.9, ["26.5", "27.0", "27.5", "28.0"]),
        (10, 2500, ["0", "500", "1k", "1.5k", "2k", "2.5k"]),
        (0.013, 0.4, ["0.0", "0.1", "0.2", "0.3", "0.4"]),
        (0, 3_000_000, ["0", "1M", "2M", "3M"]),
        (-3, 3, ["-4", "-2", "0", "2", "4"]),
    ],
)
def test_ticks_are_round_and_enclose_the_values(low: float, high: float, ticks: list[str]) -> None:
    axis = linear_axis([low, high], 0, 100)
    assert [words for _, words in axis.ticks] == ticks
    assert axis.low <= low <= high <= axis.high


def test_a_tight_axis_ends_at_the_largest_value() -> None:
    axis = linear_axis([0, 1.97], 40, 400, tight=True)
    assert (axis(0), axis(1.97)) == (40, 400)
    assert [words for _, words in axis.ticks] == ["0.0", "0.5", "1.0", "1.5"]


@pytest.mark.parametrize("values", [[], [math.nan], [27.3], [0.0], [math.inf, 5.0], [1e-9, 1e-9]])
def test_an_axis_of_hardly_any_values_has_an_extent(values: list[float]) -> None:
    axis = linear_axis(values, 0, 100)
    assert axis.high > axis.low
    assert 2 <= len(axis.ticks) <= 8
    for value in values:
        if math.isfinite(value):
            assert 0 <= axis(value) <= 100


def test_zero_belongs_to_the_axis_where_it_is_asked_for() -> None:
    assert linear_axis([20.0, 27.0], 0, 100, zero=True).low == 0
