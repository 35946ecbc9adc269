"""Distances to the nearest neighbours."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base import morton

__all__ = ["mean_neighbour_distance", "nearest_neighbours", "thin"]

_CUBE_SHIFTS = (0.0, 0.17, 0.41, 0.73)  # shares of the cube's side: each moves the cells' borders elsewhere
_CURVE_REACH = 6  # places before and behind along the curve
_BLOCK = 4_096  # points at once: their candidates fit in a cache of tens of megabytes
_MORTON_BITS = 20  # bits of an axis in the Morton code


def mean_neighbour_distance(xyz: npt.NDArray[np.floating[Any]], count: int = 3) -> npt.NDArray[np.float32]:
    """Return [P] the mean distance of each point [P, 3] to its `count` nearest others; 0 if there are fewer others.

    Distances are exact or slightly too large, as `nearest_neighbours` misses a true one now and then.
    """
    if len(xyz) <= count:
        return np.zeros(len(xyz), np.float32)
    points = np.asarray(xyz, np.float64)
    apart = points[nearest_neighbours(points, count)] - points[:, None]
    return np.asarray(np.sqrt((apart**2).sum(axis=2)).mean(axis=1), np.float32)


def nearest_neighbours(xyz: npt.NDArray[np.floating[Any]], count: int) -> npt.NDArray[np.int64]:
    """Return [P, count] the nearest others of each point [P, 3], of which there must be that many; in no order.

    They are looked for along Morton curves of four shifted grids (after Connor & Kumar, TVCG 2010), which takes
    P log P time and misses a true neighbour now and then.

    Raises:
        ValueError: there are fewer other points.
    """
    if len(xyz) <= count:
        raise ValueError(f"{len(xyz)} points have no {count} neighbours")
    points = np.asarray(xyz, np.float64) - xyz.min(axis=0)
    side = float(points.max()) or 1.0
    orders = [_along_curve(points / side * 0.5 + 0.5 * shift) for shift in _CUBE_SHIFTS]
    places = [np.argsort(order, kind="stable") for order in orders]
    reach = max(_CURVE_REACH, count)  # so that each curve alone has enough of them, at its ends, too
    nearest = np.empty((len(points), count), np.int64)
    for first in range(0, len(points), _BLOCK):
        rows = np.arange(first, min(first + _BLOCK, len(points)))
        nearest[rows] = _nearest_along(points, rows, orders, places, reach, count)
    return nearest


def _nearest_along(
    points: npt.NDArray[np.float64],
    rows: npt.NDArray[np.int64],
    orders: list[npt.NDArray[np.int64]],
    places: list[npt.NDArray[np.int64]],
    reach: int,
    count: int,
) -> npt.NDArray[np.int64]:
    """Return the nearest [R, count] of those within `reach` places on either side along one of the curves."""
    steps = np.arange(-reach, reach + 1)
    candidates = []
    for order, place in zip(orders, places, strict=True):
        candidates.append(order[np.clip(place[rows, None] + steps, 0, len(order) - 1)])
    others = np.sort(np.concatenate(candidates, axis=1), axis=1)  # [R, K]
    squares = ((points[others] - points[rows, None]) ** 2).sum(axis=2)
    repeated = np.zeros(others.shape, bool)
    repeated[:, 1:] = others[:, 1:] == others[:, :-1]
    squares[repeated | (others == rows[:, None])] = np.inf
    return np.take_along_axis(others, np.argpartition(squares, count - 1, axis=1)[:, :count], axis=1)


def thin(xyz: npt.NDArray[np.floating[Any]], distance: float) -> npt.NDArray[np.int64]:
    """Return the rows, ascending, of the first point [P, 3] in each cube of side `distance`; of all for 0."""
    if distance <= 0 or len(xyz) == 0:
        return np.arange(len(xyz))
    cells = np.floor(np.asarray(xyz, np.float64) / distance).astype(np.int64)
    _, first = np.unique(cells, axis=0, return_index=True)
    return np.sort(first)


def _along_curve(unit: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """Return the order of points [P, 3] in [0, 1) along a Morton curve."""
    cells = np.clip(unit * (1 << _MORTON_BITS), 0, (1 << _MORTON_BITS) - 1).astype(np.uint32)
    return morton.order(morton.interleave(cells))
