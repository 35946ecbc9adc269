from __future__ import annotations

import itertools
import math

import pytest

from hgs_core.report.charts.lines import Series, TopAxis, line_chart
from hgs_core.report.charts.svg import WIDTH, text_width
from tests.hgs_core.report.charts.parsed import elements, number, place, tip, words


def test_points_that_are_not_finite_are_left_out() -> None:
    assert Series("a", [0, 1, 2, 3], [5.0, math.nan, math.inf, 6.0]).points == [(0, 5.0), (3, 6.0)]


@pytest.mark.parametrize("count", [399, 400, 401, 5000])
def test_long_lines_are_thinned_and_keep_their_end(count: int) -> None:
    points = Series("a", range(count), [float(k) for k in range(count)]).points
    assert min(count, 200) <= len(points) <= 400
    assert points[-1] == (count - 1, count - 1)
    steps = {b[0] - a[0] for a, b in itertools.pairwise(points)}
    assert len(steps) == 1


def vertices(chart: str) -> list[list[tuple[float, float]]]:
    """The corners of every line."""
    paths = [element.attrib["d"].removeprefix("M").split("L") for element in elements(chart, "path")]
    return [[tuple(map(float, corner.split())) for corner in path] for path in paths]  # type: ignore[misc]


def test_a_line_goes_through_its_values_on_both_scales() -> None:
    """Reference: the places of the ticks."""
    chart = line_chart("PSNR", [Series("a", [0, 5, 10], [20.0, 25.0, 30.0])], "s", "dB")
    (corners,) = vertices(chart)
    xs = {word: number(place(chart, word), "x") for word in ("0", "10")}
    ys = {word: number(place(chart, word), "y") - 4 for word in ("20", "30")}
    assert corners[0] == (pytest.approx(xs["0"], abs=0.1), pytest.approx(ys["20"], abs=0.1))
    assert corners[2] == (pytest.approx(xs["10"], abs=0.1), pytest.approx(ys["30"], abs=0.1))
    assert corners[1] == tuple(pytest.approx((a + b) / 2, abs=0.1) for a, b in zip(corners[0], corners[2], strict=True))


def test_several_lines_are_named_at_their_ends_and_a_single_one_is_not() -> None:
    lines = [Series("first", [0, 1], [1.0, 2.0]), Series("second", [0, 1], [2.0, 1.0], 1)]
    chart = line_chart("", lines, "s", "dB")
    assert number(place(chart, "first"), "y") < number(place(chart, "second"), "y")  # it ends higher
    for name in ("first", "second"):
        assert number(place(chart, name), "x") + text_width(name) <= WIDTH
    assert "first" not in words(line_chart("", lines[:1], "s", "dB"))


def test_of_very_many_lines_as_many_are_named_as_fit() -> None:
    lines = [Series(f"camera {k}", [0, 1], [0.0, float(k)], k) for k in range(60)]
    heights = sorted(number(t, "y") for t in elements(line_chart("", lines, "s", "dB"), "text") if "camera" in t.text)
    assert 5 < len(heights) < 20
    assert all(b - a >= 13.9 for a, b in itertools.pairwise(heights))


def test_a_line_of_one_point_is_a_dot() -> None:
    chart = line_chart("", [Series("a", [3.0], [7.0])], "s", "dB")
    assert vertices(chart) == []
    assert [number(dot, "r") for dot in elements(chart, "circle") if not tip(dot)] == [3]


def test_tooltips_give_the_values_with_their_unit() -> None:
    chart = line_chart("", [Series("cam00", [0.5, 1], [27.25, 28])], "seconds", "PSNR", unit=" dB")
    assert tip(elements(chart, "circle")[0]) == "cam00\nseconds 0.5: 27.25 dB"


def test_a_line_without_a_finite_point_is_not_drawn() -> None:
    chart = line_chart("", [Series("a", [0, 1], [1.0, 2.0]), Series("b", [0, 1], [math.nan] * 2)], "s", "dB")
    assert len(vertices(chart)) == 1


def test_the_second_scale_stands_where_the_first_has_its_values() -> None:
    """Iterations 0 to 100 took 10 s, and those to 200 took 30 s more: 10 s are at half the width, 25 s at 3/4."""
    top = TopAxis("seconds", [0, 100, 200], [0.0, 10.0, 40.0])
    chart = line_chart("", [Series("a", [0, 100, 200], [0.0, 1.0, 2.0])], "iteration", "loss", top_axis=top)
    left, right = (number(place(chart, word), "x") for word in ("0.0", "200"))
    (corners,) = vertices(chart)
    left, right = corners[0][0], corners[-1][0]
    assert number(place(chart, "10"), "x") == pytest.approx((left + right) / 2, abs=0.2)
    assert number(place(chart, "25"), "x") == pytest.approx(left + 0.75 * (right - left), abs=0.2)
    assert "seconds" in words(chart)


def test_zero_is_on_the_axis_where_it_is_asked_for() -> None:
    line = [Series("a", [0, 1], [95.0, 99.0])]
    assert "0" in words(line_chart("", line, "x", "loss", y_zero=True))[1:3]
    assert "0" not in words(line_chart("", line, "x", "loss"))[1:3]
