from __future__ import annotations

import itertools

import pytest

from hgs_core.report.charts.bars import Bar, Part
from hgs_core.report.charts.columns import column_chart
from hgs_core.report.charts.svg import WIDTH
from tests.hgs_core.report.charts.parsed import elements, number, place, tip, words

GROUPS = [
    ("static", [Bar("layer 1", [Part("position", 4.0, 0, "4 kB"), Part("colour", 2.0, 1, "2 kB")], "9 splats")]),
    ("dynamic", [Bar("layer 1", [Part("position", 1.0, 0, "1 kB")], "3 splats")]),
]


def test_heights_are_proportional_and_pieces_stand_on_each_other() -> None:
    chart = column_chart("Layers", GROUPS, "kB")
    found = {tip(box): box for box in elements(chart, "rect") if tip(box)}
    position, colour, other = (
        found["layer 1 (9 splats), position: 4 kB"],
        found["layer 1 (9 splats), colour: 2 kB"],
        found["layer 1 (3 splats), position: 1 kB"],
    )
    assert number(position, "height") == pytest.approx(2 * number(colour, "height"), abs=0.2)
    assert number(position, "height") == pytest.approx(4 * number(other, "height"), abs=0.3)
    assert number(colour, "y") + number(colour, "height") == pytest.approx(number(position, "y"), abs=0.2)
    base = number(position, "y") + number(position, "height")
    assert number(other, "y") + number(other, "height") == pytest.approx(base, abs=0.2)


def test_each_group_is_named_below_its_columns() -> None:
    chart = column_chart("Layers", GROUPS, "kB")
    columns = [box for box in elements(chart, "rect") if tip(box)]
    last = columns[-1]
    assert number(place(chart, "dynamic"), "y") > number(last, "y") + number(last, "height")
    assert "kB" in words(chart)


@pytest.mark.parametrize("count", [1, 300])
def test_any_number_of_columns_fits_side_by_side(count: int) -> None:
    bars = [Bar(f"layer {k}", [Part("all", 1.0 + k, 0, f"{k}")], "") for k in range(count)]
    places = [(number(b, "x"), number(b, "width")) for b in elements(column_chart("", [("g", bars)], "kB"), "rect")]
    assert len(places) == count
    assert all(x + width <= WIDTH for x, width in places)
    assert all(b[0] > a[0] for a, b in itertools.pairwise(places))
    assert all(width <= 46 for _, width in places)
