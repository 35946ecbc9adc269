from __future__ import annotations

import itertools

import pytest

from hgs_core.report.charts.plot import Plot, make_plot
from hgs_core.report.charts.svg import FONT, WIDTH, figure, text_width
from tests.hgs_core.report.charts.parsed import elements, number, place, words


def plot(**options: bool) -> Plot:
    return make_plot([3.0, 9.7], [120.0, 480.0], top=30, height=100, right=20, **options)


def test_y_grows_upwards_and_x_to_the_right_within_their_room() -> None:
    made = plot()
    assert (made.y.start, made.y.end, made.x.end) == (130, 30, WIDTH - 20)
    assert 30 <= made.y(480.0) < made.y(120.0) <= 130
    assert made.x.start <= made.x(3.0) < made.x(9.7) <= made.x.end


def test_the_words_of_y_fit_left_of_the_area() -> None:
    made = plot()
    chart = figure(made.bottom, "", made.frame("x", "y"))
    for label in (word for _, word in made.y.ticks):
        assert number(place(chart, label), "x") - text_width(label) >= 0


def test_options_reach_their_axes() -> None:
    assert (plot(x_zero=True).x.low, plot(y_zero=True).y.low) == (0, 0)
    assert (plot().x.low, plot().y.low) == (2, 100)
    assert (plot(x_tight=True).x.high, plot().x.high) == (9.7, 10)


def test_the_frame_says_what_the_axes_are_and_has_a_line_for_every_tick() -> None:
    made = plot()
    chart = figure(made.bottom, "", made.frame("iterations", "loss"))
    assert {"iterations", "loss"} <= set(words(chart))
    assert len(elements(chart, "line")) == len(made.x.ticks) + len(made.y.ticks) + 1
    assert number(place(chart, "iterations"), "y") <= made.bottom
    assert number(place(chart, "loss"), "y") < made.y.end


@pytest.mark.parametrize("right", [20.0, 300.0])
def test_words_below_the_axis_keep_apart(right: float) -> None:
    """Where they would not, some ticks have none."""
    made = make_plot([0.0, 1_000_000.0], [0.0, 1.0], top=30, height=100, right=right)
    chart = figure(made.bottom, "", made.frame("", ""))
    below = [t for t in elements(chart, "text") if number(t, "y") == made.y.start + FONT + 5]
    ends = [
        (number(t, "x") - text_width(t.text or "") / 2, number(t, "x") + text_width(t.text or "") / 2) for t in below
    ]
    assert ends
    assert ends[-1][1] <= WIDTH
    assert all(b[0] > a[1] for a, b in itertools.pairwise(ends))
