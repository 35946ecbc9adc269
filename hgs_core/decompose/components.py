"""Connected parts of a mask, in plain numpy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["Box", "component_boxes"]

Box = tuple[int, int, int, int]
"""Left, top, right and bottom edge in pixels: columns left..right-1, rows top..bottom-1."""


def component_boxes(mask: npt.NDArray[np.bool_], count: int, smallest: int) -> list[Box]:
    """Return the boxes of at most `count` connected parts of a mask [H, W], the largest first.

    Pixels that touch along an edge are connected. Parts of fewer than `smallest` pixels are left out.
    """
    steps = np.diff(np.pad(mask.astype(np.int8), ((0, 0), (1, 1))), axis=1)
    rows, lefts = np.nonzero(steps == 1)
    rights = np.nonzero(steps == -1)[1]
    parents = _joined_runs(rows, lefts, rights)
    roots, part = np.unique(parents, return_inverse=True)
    area = np.bincount(part, weights=rights - lefts, minlength=len(roots))
    boxes: list[Box] = []
    for root in np.argsort(-area, kind="stable")[:count]:
        if area[root] < smallest:
            break
        runs = part == root
        left, right = int(lefts[runs].min()), int(rights[runs].max())
        boxes.append((left, int(rows[runs].min()), right, int(rows[runs].max()) + 1))
    return boxes


def _joined_runs(
    rows: npt.NDArray[np.int64], lefts: npt.NDArray[np.int64], rights: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """Return for each run of set pixels, in reading order, the first run of its part (union-find over the rows)."""
    parents = list(range(len(rows)))

    def root(run: int) -> int:
        while parents[run] != run:
            parents[run] = parents[parents[run]]
            run = parents[run]
        return run

    above = 0
    for run in range(len(rows)):
        while rows[above] < rows[run] - 1 or (rows[above] == rows[run] - 1 and rights[above] <= lefts[run]):
            above += 1
        other = above
        while other < run and rows[other] == rows[run] - 1 and lefts[other] < rights[run]:
            first, second = sorted((root(other), root(run)))
            parents[second] = first
            other += 1
    return np.array([root(run) for run in range(len(rows))], np.int64)
