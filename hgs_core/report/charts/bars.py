"""Horizontal bars, stacked or not, with their values behind them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from hgs_core.report.charts.axis import linear_axis
from hgs_core.report.charts.chart_labels import legend
from hgs_core.report.charts.svg import FONT, WIDTH, box, colour, figure, line, shortened, text, text_width

__all__ = ["Bar", "Part", "bar_chart", "legend_of"]

_ROW_HEIGHT = 23.0  # user units
_LONGEST_NAME = 150.0  # user units of a bar's name


@dataclass(frozen=True)
class Part:
    """A piece of a stacked bar."""

    name: str
    value: float  # not negative
    colour: int
    words: str  # the value as tooltips say it


@dataclass(frozen=True)
class Bar:
    """One bar: its pieces from the axis outwards, and the label behind it."""

    name: str
    parts: Sequence[Part]
    words: str = ""
    mark: float = math.nan  # a value to mark across the bar
    mark_words: str = ""

    @property
    def total(self) -> float:
        """Return the sum of the parts."""
        return sum(part.value for part in self.parts)


def bar_chart(name: str, bars: Sequence[Bar], x_label: str) -> str:
    """Return the chart of at least one bar; pieces of one name share one colour, and a legend if there are several."""
    parts, top = legend_of(bars)
    left = min(_LONGEST_NAME, max(text_width(bar.name) for bar in bars)) + 8
    right = max(text_width(bar.words) for bar in bars) + 10
    bottom = top + _ROW_HEIGHT * len(bars) + 4
    axis = linear_axis([bar.total for bar in bars], left, WIDTH - right, zero=True, tight=True, count=4)
    for value, words in axis.ticks:
        parts += [
            line(axis(value), top, axis(value), bottom),
            text(axis(value), bottom + FONT + 3, words, anchor="middle"),
        ]
    for row, bar in enumerate(bars):
        y = top + row * _ROW_HEIGHT + 4
        parts.append(text(left - 6, y + FONT, shortened(bar.name, _LONGEST_NAME), anchor="end"))
        x = left
        for part in bar.parts:
            width = axis(part.value) - axis.start
            if width > 0:
                tip = f"{bar.name}, {part.name}: {part.words}" if part.name else f"{bar.name}: {part.words}"
                parts.append(box(x, y, max(0.5, width - 0.7), _ROW_HEIGHT - 7, colour(part.colour), tip))
            x += width
        if math.isfinite(bar.mark):
            parts.append(box(axis(bar.mark) - 1.5, y - 2, 3, _ROW_HEIGHT - 3, "var(--ink)", bar.mark_words))
        parts.append(text(x + 6, y + FONT, bar.words))
    parts.append(text((axis.start + axis.end) / 2, bottom + 2 * FONT + 8, x_label, anchor="middle", kind="faint"))
    return figure(bottom + 2 * FONT + 16, name, parts)


def legend_of(bars: Sequence[Bar]) -> tuple[list[str], float]:
    """Return the legend of the pieces, in the order of their colours, and its height; none for one kind."""
    kinds = {part.name: part.colour for bar in bars for part in bar.parts if part.value > 0}
    names = sorted(kinds, key=lambda name: kinds[name])
    return legend(names, [colour(kinds[name]) for name in names]) if len(kinds) > 1 else ([], 0.0)
