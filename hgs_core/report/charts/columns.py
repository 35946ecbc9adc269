"""Stacked columns in groups: many of them, without a name each."""

from __future__ import annotations

from collections.abc import Sequence

from hgs_core.report.charts.axis import linear_axis
from hgs_core.report.charts.bars import Bar, legend_of
from hgs_core.report.charts.svg import FONT, WIDTH, box, colour, figure, line, text, text_width

__all__ = ["column_chart"]

_AREA_HEIGHT = 170.0  # user units
_GROUP_GAP = 14.0  # between groups
_WIDEST_COLUMN = 46.0  # column


def column_chart(name: str, groups: Sequence[tuple[str, Sequence[Bar]]], y_label: str) -> str:
    """Return the chart of groups of columns; no group is empty. A group's name stands below it."""
    columns = [bar for _, bars in groups for bar in bars]
    parts, top = legend_of(columns)
    top += 24
    y = linear_axis([bar.total for bar in columns], top + _AREA_HEIGHT, top, zero=True)
    left = max(text_width(words) for _, words in y.ticks) + 8
    parts.append(text(0, top - 10, y_label, kind="faint"))
    for value, words in y.ticks:
        parts += [line(left, y(value), WIDTH, y(value)), text(left - 6, y(value) + 4, words, anchor="end")]
    width = min(_WIDEST_COLUMN, (WIDTH - left - _GROUP_GAP * (len(groups) + 1)) / len(columns))
    x = left + _GROUP_GAP
    for group, bars in groups:
        middle = x + width * len(bars) / 2
        half = text_width(group) / 2
        parts.append(text(max(left + half, min(middle, WIDTH - half)), y.start + FONT + 6, group, anchor="middle"))
        for bar in bars:
            base = y.start
            for part in bar.parts:
                tall = y.start - y(part.value)
                if tall > 0:
                    tip = f"{bar.name} ({bar.words}), {part.name}: {part.words}"
                    wide = max(0.6, width * 0.86)
                    parts.append(box(x + (width - wide) / 2, base - tall, wide, tall, colour(part.colour), tip))
                base -= tall
            x += width
        x += _GROUP_GAP
    parts.append(line(left, y.start, WIDTH, y.start, "var(--faint)"))
    return figure(y.start + FONT + 14, name, parts)
