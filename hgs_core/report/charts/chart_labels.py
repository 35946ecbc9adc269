"""Where labels go so that none covers another: in a column beside lines, around points, in rows above bars."""

from __future__ import annotations

import math
from collections.abc import Sequence

from hgs_core.report.charts.svg import FONT, WIDTH, box, text, text_width

__all__ = ["Box", "around_points", "legend", "overlap", "spread"]

Box = tuple[float, float, float, float]  # x0, y0, x1, y1
_LABEL_DISTANCES = (11.0, 22.0, 36.0, 52.0)  # distances of a label from its point
_LABEL_DIRECTIONS = (0, 180, 270, 90, 315, 225, 45, 135)  # degrees clockwise from the right, the best first
_LABEL_HEIGHT = FONT + 2  # height of a label's box
_LEGEND_ROW_HEIGHT = 17.0  # height of a row


def spread(places: Sequence[float], gap: float, low: float, high: float) -> list[float]:
    """Move `places` as little as a greedy pass can, so that all lie in [low, high] and `gap` apart.

    The caller makes sure that they fit: (len(places) - 1) * gap <= high - low.
    """
    order = sorted(range(len(places)), key=lambda i: places[i])
    moved = [0.0] * len(places)
    edge = low
    for i in order:
        moved[i] = max(places[i], edge)
        edge = moved[i] + gap
    edge = high
    for i in reversed(order):
        moved[i] = min(moved[i], edge)
        edge = moved[i] - gap
    return moved


def overlap(a: Box, b: Box) -> bool:
    """Return whether two boxes share more than an edge."""
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def around_points(points: Sequence[tuple[float, float]], words: Sequence[str], frame: Box) -> list[Box | None]:
    """Return the boxes of labels near their points, inside `frame`, free of other labels and of all points.

    None where no place is free.
    """
    taken: list[Box] = [(x - 7, y - 7, x + 7, y + 7) for x, y in points]
    boxes: list[Box | None] = []
    for (x, y), word in zip(points, words, strict=True):
        found = next((b for b in _candidates(x, y, text_width(word)) if _free(b, taken, frame)), None)
        if found is not None:
            taken.append(found)
        boxes.append(found)
    return boxes


def legend(names: Sequence[str], colours: Sequence[str]) -> tuple[list[str], float]:
    """Return swatches with names in rows from the top of a chart, and the height they take."""
    parts: list[str] = []
    x, y = 0.0, 0.0
    for name, fill in zip(names, colours, strict=True):
        width = 16 + text_width(name) + 12
        if x > 0 and x + width > WIDTH:
            x, y = 0.0, y + _LEGEND_ROW_HEIGHT
        parts += [box(x, y + 2, 11, 11, fill), text(x + 16, y + 12, name)]
        x += width
    return parts, (y + _LEGEND_ROW_HEIGHT + 6 if names else 0.0)


def _candidates(x: float, y: float, width: float) -> list[Box]:
    boxes: list[Box] = []
    for ring in _LABEL_DISTANCES:
        for degrees in _LABEL_DIRECTIONS:
            dx, dy = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            centre_x = x + dx * (ring + width / 2) if abs(dx) > 0.1 else x
            centre_y = y + dy * (ring + _LABEL_HEIGHT / 2) if abs(dy) > 0.1 else y
            half = width / 2
            boxes.append((centre_x - half, centre_y - _LABEL_HEIGHT / 2, centre_x + half, centre_y + _LABEL_HEIGHT / 2))
    return boxes


def _free(candidate: Box, taken: Sequence[Box], frame: Box) -> bool:
    inside = candidate[0] >= frame[0] and candidate[1] >= frame[1]
    inside = inside and candidate[2] <= frame[2] and candidate[3] <= frame[3]
    return inside and not any(overlap(candidate, other) for other in taken)
