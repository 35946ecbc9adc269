"""Line charts with the names of the lines at their ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hgs_core.report.charts.axis import linear_axis
from hgs_core.report.charts.chart_labels import spread
from hgs_core.report.charts.plot import Plot, make_plot
from hgs_core.report.charts.svg import (
    FONT,
    WIDTH,
    colour,
    dot,
    figure,
    line,
    path,
    shortened,
    text,
    text_width,
)

__all__ = ["Series", "TopAxis", "line_chart"]

_AREA_HEIGHT = 180.0  # user units
_LONGEST_NAME = 110.0  # user units of a line's name
_TOP_LABEL = FONT + 14  # room for the second scale's label, above the area
_MOST_POINTS = 400  # points of a line: about one per user unit
_MOST_TIPS = 80  # tips of a line


@dataclass(frozen=True)
class Series:
    """One line; points that are not finite are left out. `x` ascends."""

    name: str
    x: Sequence[float]
    y: Sequence[float]
    colour: int = 0

    @property
    def points(self) -> list[tuple[float, float]]:
        """Return the finite points, thinned to the resolution of a chart; the last one is always there."""
        finite = [(x, y) for x, y in zip(self.x, self.y, strict=True) if math.isfinite(x) and math.isfinite(y)]
        every = max(1, -(-len(finite) // _MOST_POINTS))
        return finite[(len(finite) - 1) % every :: every]


@dataclass(frozen=True)
class TopAxis:
    """A second scale for x along the top: `values` ascend with `x`."""

    label: str
    x: Sequence[float]
    values: Sequence[float]


def line_chart(
    name: str,
    series: Sequence[Series],
    x_label: str,
    y_label: str,
    *,
    top_axis: TopAxis | None = None,
    y_zero: bool = False,
    unit: str = "",
) -> str:
    """Return the chart of lines that have at least one finite point each; `unit` follows the numbers in tooltips."""
    drawn = [(line, line.points) for line in series if line.points]
    labels = [shortened(one.name, _LONGEST_NAME) for one, _ in drawn] if len(drawn) > 1 else []
    right = max((text_width(label) for label in labels), default=0.0) + (24 if labels else 20)
    xs = [x for _, points in drawn for x, _ in points]
    ys = [y for _, points in drawn for _, y in points]
    top = 44.0 if top_axis else 28.0
    plot = make_plot(xs, ys, top=top, height=_AREA_HEIGHT, right=right, x_tight=True, y_zero=y_zero)
    if top_axis:
        parts = [*plot.frame(x_label, y_label, _TOP_LABEL), *_top_ticks(plot, top_axis)]
    else:
        parts = plot.frame(x_label, y_label)
    for one, points in drawn:
        parts += _drawn(plot, one, points, x_label, unit)
    if labels:
        parts += _end_labels(plot, [(one.colour, points[-1]) for one, points in drawn], labels)
    return figure(plot.bottom, name, parts)


def _drawn(plot: Plot, one: Series, points: list[tuple[float, float]], x_label: str, unit: str) -> list[str]:
    places = [(plot.x(x), plot.y(y)) for x, y in points]
    parts = [path(places, colour(one.colour))] if len(places) > 1 else [dot(*places[0], 3, colour(one.colour))]
    every = max(1, -(-len(points) // _MOST_TIPS))
    for (x, y), place in list(zip(points, places, strict=True))[::every]:
        parts.append(dot(*place, 5, "transparent", tip=f"{one.name}\n{x_label} {x:.5g}: {y:.5g}{unit}"))
    return parts


def _top_ticks(plot: Plot, axis: TopAxis) -> list[str]:
    """Ticks at round values of the second scale, at the places where x has them; even steps need not be even there."""
    y = plot.y.end
    scale = linear_axis([axis.values[0], axis.values[-1]], 0.0, 1.0, zero=True, tight=True, count=8)
    parts = [line(plot.x.start, y, plot.x.end, y, "var(--faint)")]
    free = 0.0
    for value, words in scale.ticks:
        if not axis.values[0] <= value <= axis.values[-1]:
            continue
        x = plot.x(float(np.interp(value, axis.values, axis.x)))
        half = text_width(words) / 2
        parts.append(line(x, y - 4, x, y, "var(--faint)"))
        if x - half >= free:
            parts.append(text(x, y - 8, words, anchor="middle"))
            free = x + half + 6
    return [*parts, text(plot.x.end, y - _TOP_LABEL, axis.label, anchor="end", kind="faint")]


def _end_labels(plot: Plot, ends: Sequence[tuple[int, tuple[float, float]]], labels: Sequence[str]) -> list[str]:
    """Names right of the lines' ends, with a stroke that leads to them; as many as fit, spread over the lines."""
    room = int((plot.y.start - plot.y.end) // (FONT + 2)) + 1
    order = sorted(range(len(ends)), key=lambda i: -ends[i][1][1])
    chosen = [order[round(k)] for k in np.linspace(0, len(order) - 1, min(room, len(order)))]
    places = spread([plot.y(ends[i][1][1]) for i in chosen], FONT + 2, plot.y.end, plot.y.start)
    parts: list[str] = []
    for i, y in zip(chosen, places, strict=True):
        number, (last_x, last_y) = ends[i]
        x = plot.x.end + 14
        parts.append(line(plot.x(last_x) + 1, plot.y(last_y), x - 3, y, colour(number), 1.2))
        parts.append(text(min(x, WIDTH - text_width(labels[i])), y + 4, labels[i]))
    return parts
