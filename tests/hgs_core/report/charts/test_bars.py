from __future__ import annotations

import pytest

from hgs_core.report.charts.bars import Bar, Part, bar_chart, legend_of
from hgs_core.report.charts.svg import WIDTH
from tests.hgs_core.report.charts.parsed import elements, number, place, tip, words

BARS = [
    Bar("first", [Part("static", 30.0, 0, "30 kB"), Part("dynamic", 10.0, 1, "10 kB")], "40 kB"),
    Bar("second", [Part("static", 20.0, 0, "20 kB"), Part("dynamic", 0.0, 1, "none")], "20 kB"),
]


def boxes(chart: str) -> dict[str, tuple[float, float]]:
    """Left end and width of elements with a tooltip."""
    return {tip(box): (number(box, "x"), number(box, "width")) for box in elements(chart, "rect") if tip(box)}


def test_lengths_are_proportional_to_the_values() -> None:
    found = boxes(bar_chart("Sizes", BARS, "kB"))
    unit = (found["first, static: 30 kB"][1] + 0.7) / 30  # 0.7: the gap behind each piece
    assert found["first, dynamic: 10 kB"][1] + 0.7 == pytest.approx(10 * unit, abs=0.1)
    assert found["second, static: 20 kB"][1] + 0.7 == pytest.approx(20 * unit, abs=0.1)


def test_pieces_stand_one_behind_the_other_and_empty_ones_not_at_all() -> None:
    found = boxes(bar_chart("Sizes", BARS, "kB"))
    start, width = found["first, static: 30 kB"]
    assert found["first, dynamic: 10 kB"][0] == pytest.approx(start + width + 0.7, abs=0.11)
    assert found["second, static: 20 kB"][0] == start
    assert len(found) == 3


def test_names_values_and_the_axis_are_written() -> None:
    chart = bar_chart("Sizes", BARS, "kB")
    assert {"first", "second", "40 kB", "20 kB", "kB", "0", "10", "40"} <= set(words(chart))
    assert number(place(chart, "40 kB"), "x") < WIDTH


def test_a_mark_stands_at_its_value_across_the_bar() -> None:
    chart = bar_chart("PSNR", [Bar("cam00", [Part("", 30.0, 0, "30")], "30", 15.0, "worst 15")], "dB")
    found = boxes(chart)
    (left, width), (mark, thick) = found["cam00: 30"], found["worst 15"]
    assert mark + thick / 2 == pytest.approx(left + (width + 0.7) / 2, abs=0.1)


def test_there_is_a_legend_where_pieces_have_several_names() -> None:
    parts, height = legend_of(BARS)
    assert height > 0
    assert [name in "".join(parts) for name in ("static", "dynamic")] == [True, True]
    assert legend_of([Bar("one", [Part("static", 1.0, 0, "1")])]) == ([], 0.0)
    assert legend_of(BARS[1:]) == ([], 0.0)  # its other piece is empty


def test_a_legend_is_in_the_order_of_the_colours() -> None:
    parts, _ = legend_of([Bar("b", [Part("later", 1.0, 3, "1"), Part("sooner", 1.0, 2, "1")])])
    assert "".join(parts).index("sooner") < "".join(parts).index("later")
