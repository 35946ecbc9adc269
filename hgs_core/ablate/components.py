"""Connected components of a mask, by runs of set pixels that touch from row to row."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["component_labels"]


def component_labels(mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.int32]:
    """Return [H, W] which component a pixel belongs to: 1, 2, ... in reading order of their first pixels; 0 is none.

    Pixels that touch at a corner are connected.
    """
    height, width = mask.shape
    padded = np.zeros((height, width + 2), np.int8)
    padded[:, 1:-1] = mask
    borders = np.diff(padded, axis=1)
    rows, starts = np.nonzero(borders == 1)
    _, ends = np.nonzero(borders == -1)  # one past the last pixel
    _, numbers = np.unique(_joined(*_touching(rows, starts, ends, width), len(rows)), return_inverse=True)
    steps = np.zeros((height, width + 1), np.int32)
    steps[rows, starts] = numbers + 1
    steps[rows, ends] = -(numbers + 1)
    return np.asarray(np.cumsum(steps, axis=1, dtype=np.int32)[:, :width])


def _touching(
    rows: npt.NDArray[np.int64], starts: npt.NDArray[np.int64], ends: npt.NDArray[np.int64], width: int
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the pairs (upper, lower) of runs that touch; the lower ones of an upper run follow each other."""
    stride = width + 2  # no column of one row reaches those of the next
    below = (rows + 1) * stride
    first = np.searchsorted(rows * stride + ends, below + starts, side="left")
    last = np.searchsorted(rows * stride + starts, below + ends, side="right")
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
