"""The frame of a chart with two axes: grid, ticks, and labels of axes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from hgs_core.report.charts.axis import Axis, linear_axis
from hgs_core.report.charts.svg import FONT, WIDTH, line, text, text_width

__all__ = ["Plot", "make_plot"]

_AXIS_ROOM = 40.0  # the x axis: ticks and label
_TICK_ROOM = 1.25  # times the width of a tick's words, so that neighbours stay apart


@dataclass(frozen=True)
class Plot:
    """Two axes; x grows rightwards and y upwards."""

    x: Axis
    y: Axis

    @property
    def bottom(self) -> float:
        """Return the height of the chart: the lower edge of the x axis's label."""
        return self.y.start + _AXIS_ROOM

    def frame(self, x_label: str, y_label: str, above: float = 10.0) -> list[str]:
        """Return grid, ticks and labels; `y_label` stands `above` the y axis."""
        parts = [text(0, self.y.end - above, y_label, kind="faint")]
        for value, words in self.y.ticks:
            y = self.y(value)
            parts += [line(self.x.start, y, self.x.end, y), text(self.x.start - 6, y + 4, words, anchor="end")]
        free = 0.0
        for value, words in self.x.ticks:
            x, half = self.x(value), text_width(words) / 2
            if x - half * _TICK_ROOM >= free and x + half <= WIDTH:
                parts.append(text(x, self.y.start + FONT + 5, words, anchor="middle"))
                free = x + half * _TICK_ROOM
            parts.append(line(x, self.y.start, x, self.y.start + 4, "var(--faint)"))
        parts.append(line(self.x.start, self.y.start, self.x.end, self.y.start, "var(--faint)"))
        middle = (self.x.start + self.x.end) / 2
        return [*parts, text(middle, self.y.start + 2 * FONT + 10, x_label, anchor="middle", kind="faint")]


def make_plot(
    xs: Iterable[float],
    ys: Iterable[float],
    *,
    top: float,
    height: float,
    right: float,
    x_zero: bool = False,
    x_tight: bool = False,
    y_zero: bool = False,
) -> Plot:
    """Return axes over the values.

    Args:
        xs: all values along x.
        ys: all values along y.
        top: place of the upper end of y.
        height: of the area, user units.
        right: room to leave on the right.
        x_zero: x begins at zero or below.
        x_tight: x ends at its largest value.
        y_zero: y begins at zero or below.
    """
    y = linear_axis(ys, top + height, top, zero=y_zero)
    left = max(text_width(words) for _, words in y.ticks) + 8
    return Plot(linear_axis(xs, left, WIDTH - right, zero=x_zero, tight=x_tight), y)
