"""Scatter charts with a name beside each point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hgs_core.report.charts.chart_labels import around_points
from hgs_core.report.charts.plot import make_plot
from hgs_core.report.charts.svg import FONT, WIDTH, colour, dot, figure, line, shortened, text

__all__ = ["Point", "scatter_chart"]

_AREA_HEIGHT = 220.0  # user units
_LONGEST_NAME = 130.0  # user units of a point's name


@dataclass(frozen=True)
class Point:
    """A named point; a hollow one is not comparable with the filled ones."""

    name: str
    x: float
    y: float
    colour: int
    hollow: bool
    words: str  # tooltip


def scatter_chart(name: str, points: Sequence[Point], x_label: str, y_label: str) -> str:
    """Return the chart of at least one point with finite places; x begins at zero."""
    top = 28.0
    plot = make_plot([p.x for p in points], [p.y for p in points], top=top, height=_AREA_HEIGHT, right=16, x_zero=True)
    parts = plot.frame(x_label, y_label)
    places = [(plot.x(p.x), plot.y(p.y)) for p in points]
    labels = [shortened(p.name, _LONGEST_NAME) for p in points]
    boxes = around_points(places, labels, (plot.x.start, top - 8, WIDTH, plot.y.start))
    for point, (x, y), label, place in zip(points, places, labels, boxes, strict=True):
        if place is not None:
            middle_x, middle_y = (place[0] + place[2]) / 2, (place[1] + place[3]) / 2
            if abs(middle_y - y) > 2 * FONT:
                edge = place[3] if middle_y < y else place[1]
                parts.append(line(x, y, middle_x, edge, "var(--faint)"))
            parts.append(text(middle_x, middle_y + 4, label, anchor="middle"))
        fill = "var(--surface)" if point.hollow else colour(point.colour)
        parts.append(dot(x, y, 5, fill, colour(point.colour), point.words))
    return figure(plot.bottom, name, parts)
