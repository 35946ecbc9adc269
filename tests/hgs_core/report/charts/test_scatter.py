from __future__ import annotations

import pytest

from hgs_core.report.charts.scatter import Point, scatter_chart
from tests.hgs_core.report.charts.parsed import elements, number, place, tip, words

POINTS = [
    Point("ours", 10.0, 27.0, 0, hollow=False, words="ours: 27 dB"),
    Point("theirs", 20.0, 25.0, 1, hollow=True, words="theirs: 25 dB"),
]


def test_points_stand_at_their_values() -> None:
    """Reference: the places of the ticks."""
    chart = scatter_chart("Speed", POINTS, "minutes", "dB")
    dots = {tip(dot): dot for dot in elements(chart, "circle")}
    for name, x, y in (("ours: 27 dB", "10", "27.0"), ("theirs: 25 dB", "20", "25.0")):
        assert number(dots[name], "cx") == pytest.approx(number(place(chart, x), "x"), abs=0.1)
        assert number(dots[name], "cy") == pytest.approx(number(place(chart, y), "y") - 4, abs=0.1)


def test_x_begins_at_zero() -> None:
    assert "0" in words(scatter_chart("Speed", POINTS, "minutes", "dB"))


def test_what_cannot_be_compared_is_hollow() -> None:
    fills = {tip(dot): dot.attrib["fill"] for dot in elements(scatter_chart("", POINTS, "x", "y"), "circle")}
    assert fills == {"ours: 27 dB": "var(--s0)", "theirs: 25 dB": "var(--surface)"}


def test_names_stand_beside_their_points_shortened_if_need_be() -> None:
    long = Point("a run whose name goes on and on for ever", 15.0, 26.0, 2, hollow=False, words="")
    chart = scatter_chart("", [*POINTS, long], "x", "y")
    assert {"ours", "theirs"} <= set(words(chart))
    assert any(word.startswith("a run whose") and word.endswith("…") for word in words(chart))
    dot = next(dot for dot in elements(chart, "circle") if tip(dot) == "ours: 27 dB")
    assert abs(number(place(chart, "ours"), "x") - number(dot, "cx")) < 60
