"""Connected components of a mask, by runs of set pixels that touch from row to row."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["Box", "component_boxes", "component_labels"]

Box = tuple[int, int, int, int]
"""Left, top, right and bottom edge in pixels: columns left..right-1, rows top..bottom-1."""

Runs = tuple[npt.NDArray[np.int64], npt.NDArray[np.int64], npt.NDArray[np.int64]]
"""Rows, first columns, and columns one past the last, in reading order."""


def component_labels(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.int32]:
    """Return [H, W] which component a pixel belongs to: 1, 2, ... in reading order of their first pixels; 0 is none.

    Pixels that touch at a corner are connected.
    """
    height, width = mask.shape
    rows, starts, ends = _runs(mask)
    numbers = _components((rows, starts, ends), width, corners=True)
    steps = np.zeros((height, width + 1), np.int32)
    steps[rows, starts] = numbers + 1
    steps[rows, ends] = -(numbers + 1)
    return np.asarray(np.cumsum(steps, axis=1, dtype=np.int32)[:, :width])


def component_boxes(mask: npt.NDArray[np.bool_], count: int, smallest: int) -> list[Box]:
    """Return the boxes of at most `count` connected parts of a mask [H, W], the largest first.

    Pixels that touch along an edge are connected. Parts of fewer than `smallest` pixels are left out.
    """
    rows, starts, ends = _runs(mask)
    part = _components((rows, starts, ends), mask.shape[1], corners=False)
    area = np.bincount(part, weights=ends - starts)
    boxes: list[Box] = []
    for number in np.argsort(-area, kind="stable")[:count]:
        if area[number] < smallest:
            break
        runs = part == number
        left, right = int(starts[runs].min()), int(ends[runs].max())
        boxes.append((left, int(rows[runs].min()), right, int(rows[runs].max()) + 1))
    return boxes


def _runs(mask: npt.NDArray[np.bool_]) -> Runs:
    borders = np.diff(np.pad(mask.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    rows, starts = np.nonzero(borders == 1)
    return rows, starts, np.nonzero(borders == -1)[1]


def _components(runs: Runs, width: int, *, corners: bool) -> npt.NDArray[np.int64]:
    """Return the component of each run, 0, 1, ... in the order of their first runs; touching at `corners` may count."""
    _, numbers = np.unique(_joined(*_touching(runs, width, corners), len(runs[0])), return_inverse=True)
    return np.asarray(numbers, np.int64)


def _touching(runs: Runs, width: int, corners: bool) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the pairs (upper, lower) of runs that touch; the lower ones of an upper run follow each other."""
    rows, starts, ends = runs
    stride = width + 2  # no column of one row reaches those of the next
    below = (rows + 1) * stride
    first = np.searchsorted(rows * stride + ends, below + starts, side="left" if corners else "right")
    last = np.searchsorted(rows * stride + starts, below + ends, side="right" if corners else "left")
    counts = np.maximum(last - first, 0)
    upper = np.repeat(np.arange(len(rows)), counts)
    before = np.cumsum(counts) - counts
    lower = np.repeat(first - before, counts) + np.arange(counts.sum())
    return upper, lower


def _joined(first: npt.NDArray[np.int64], second: npt.NDArray[np.int64], count: int) -> npt.NDArray[np.int64]:
    """Return for each of `count` runs the least run that a chain of pairs leads to."""
    least = np.arange(count)
    while True:
        low = np.minimum(least[first], least[second])
        found = least.copy()
        np.minimum.at(found, least[first], low)
        np.minimum.at(found, least[second], low)
        while not np.array_equal(found, found[found]):
            found = found[found]
        if np.array_equal(found, least):
            return least
        least = found
