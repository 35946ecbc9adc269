"""The limits of azimuth, elevation and distance to the views that cameras saw (docs/format.md, "Seen limits")."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hgs_core.base.arrays import Doubles
from hgs_core.codec.format.json_fields import Field

__all__ = ["Range", "SeenLimits", "range_of"]

Range = tuple[float, float]
"""Lowest and highest, ascending."""

FEWEST, MOST = 2, 64  # columns, and rows


@dataclass(frozen=True)
class SeenLimits:
    """Limits on a grid of K azimuths, the columns, and M elevations, the rows; between them they are interpolated."""

    elevations: tuple[Range, ...]  # [K] radians
    distances: tuple[tuple[Range, ...], ...]  # [K][M] world units
    azimuth: Range | None = None  # radians; None: as in the space

    def elevation(self, azimuth: float, half: float | None) -> Range:
        """Return the range of elevations at an azimuth of a space of half the width `half`; None: all round."""
        return _mixed(np.array(self.elevations), *_columns(azimuth, half, len(self.elevations)))

    def distance(self, azimuth: float, elevation: float, half: float | None, box: Range) -> Range:
        """Return the range of distances in a direction; the rows of the grid cover the elevations of `box`."""
        columns = np.array(self.distances)
        low, high = box
        row = (elevation - low) / (high - low) * (columns.shape[1] - 1) if high > low else 0.0
        first, share = _place(row, columns.shape[1])
        rows = columns[:, first] * (1 - share) + columns[:, first + 1] * share
        return _mixed(rows, *_columns(azimuth, half, len(columns)))

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        document: dict[str, Any] = {} if self.azimuth is None else {"azimuth": list(self.azimuth)}
        return document | {
            "elevation": [list(pair) for pair in self.elevations],
            "distance": [[list(pair) for pair in column] for column in self.distances],
        }

    @classmethod
    def read(cls, field: Field, half: float | None, elevation: Range, distance: Range) -> SeenLimits:
        """Read the plain form, which stays within the ranges of the space; `half` is of its azimuths, None: all round.

        Raises:
            InputError: names the field, the value and what it should be.
        """
        elevations = tuple(_inside(pair, elevation) for pair in _nodes(field["elevation"]))
        columns = field["distance"].items(len(elevations))
        distances = tuple(tuple(_inside(pair, distance) for pair in _nodes(column)) for column in columns)
        for column, found in zip(columns, distances, strict=True):
            if len(found) != len(distances[0]):
                raise column.error(f"has {len(found)} rows, expected {len(distances[0])}, as the first column has")
        azimuth = None
        if "azimuth" in field.mapping():
            if half is None:
                raise field["azimuth"].error("is given for a captured space that is open all round", "leave it out")
            azimuth = _inside(field["azimuth"], (-half, half))
        return cls(elevations, distances, azimuth)


def range_of(field: Field) -> Range:
    """Read two ascending numbers.

    Raises:
        InputError: names the field and the value.
    """
    low, high = field.numbers(2)
    if low > high:
        raise field.error(f"is {field.value!r}, expected ascending numbers")
    return low, high


def _nodes(field: Field) -> Sequence[Field]:
    items = field.items()
    if not FEWEST <= len(items) <= MOST:
        raise field.error(f"has {len(items)} entries, expected {FEWEST} to {MOST}")
    return items


def _inside(field: Field, box: Range) -> Range:
    low, high = range_of(field)
    if low < box[0] or high > box[1]:
        raise field.error(f"is {field.value!r}, expected within {list(box)}, the range of the captured space")
    return low, high


def _columns(azimuth: float, half: float | None, count: int) -> tuple[int, int, float]:
    """Return the columns on either side of an azimuth, and how near it is to the second."""
    if half is None:
        turn = azimuth / (2 * math.pi) * count
        first = math.floor(turn)
        return first % count, (first + 1) % count, turn - first
    first, share = _place((azimuth / half + 1) / 2 * (count - 1), count)
    return first, first + 1, share


def _place(number: float, count: int) -> tuple[int, float]:
    """Return the node before a place on a line of nodes 0 to `count` - 1, and its share of the way to the next."""
    number = min(max(number, 0.0), count - 1.0)
    first = min(int(number), count - 2)
    return first, number - first


def _mixed(pairs: Doubles, first: int, second: int, share: float) -> Range:
    low, high = pairs[first] + (pairs[second] - pairs[first]) * share  # exact between equal ones
    return float(low), float(high)
