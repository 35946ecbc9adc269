"""Depths of the pixels that found none, from those around them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["completed"]

_ROUNDS = 400  # rounds of averaging with four neighbours; a coarse guess has the large shapes already


def completed(values: npt.NDArray[np.floating[Any]], known: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """Return values [H, W] for all pixels: the known ones, and between them the smoothest that meet these.

    An unknown pixel is the mean of its four neighbours. Inverse depths of a plane are linear in the
    picture, and a linear function is the mean of its neighbours everywhere: a blank part of a wall becomes the plane
    that its frame lies in. Without any known pixel all are 0.
    """
    filled = _coarse_to_fine(np.where(known, values, 0.0).astype(np.float64), known)
    for _ in range(_ROUNDS if not known.all() else 0):
        around = np.pad(filled, 1, mode="edge")
        mean = 0.25 * (around[:-2, 1:-1] + around[2:, 1:-1] + around[1:-1, :-2] + around[1:-1, 2:])
        filled = np.where(known, filled, mean)
    return filled


def _coarse_to_fine(values: npt.NDArray[np.float64], known: npt.NDArray[np.bool_]) -> npt.NDArray[np.float64]:
    """Fill gaps with the mean of the smallest of ever larger blocks that knows one (Gortler et al., SIGGRAPH 1996)."""
    if known.all() or not known.any():
        return values
    height, width = values.shape
    blocks = (-(-height // 2), 2, -(-width // 2), 2)
    room = ((0, blocks[0] * 2 - height), (0, blocks[2] * 2 - width))
    counts = np.pad(known, room).reshape(blocks).sum((1, 3))
    sums = np.pad(values * known, room).reshape(blocks).sum((1, 3))
    coarse = _coarse_to_fine(sums / np.maximum(counts, 1), counts > 0)
    return np.where(known, values, coarse.repeat(2, 0).repeat(2, 1)[:height, :width])
