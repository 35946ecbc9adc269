"""Depths of the pixels that found none, from those around them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["completed"]

_BLOCK = 5  # pixels of a side of the blocks that the plate is solved on: 2,400 of a picture of 60,000 pixels
_STIFFNESS = 3.0  # of the plate against a block of known pixels: it follows them within about ten pixels
_TENSION = 1e-6  # what slopes cost beside bends: where nothing is known about a slope, there is none
_BEYOND = 2.0  # times the largest of the known values, or the smallest divided by it, is as far as slopes are followed
_ROUNDS = 400  # of averaging with the four neighbours; a coarse guess has the large shapes already

Doubles = npt.NDArray[np.float64]


def completed(values: npt.NDArray[np.floating[Any]], known: npt.NDArray[np.bool_]) -> Doubles:
    """Return positive values [H, W] for all pixels: the known ones, and what these go on as.

    The inverse depths of a plane are linear in the picture. A thin plate (Duchon, 1977; Terzopoulos, PAMI 1988) bends
    as little as it may and is linear where nothing bends it, so that a blank part of a wall becomes the plane its frame
    lies in, and one that goes on beyond what is known keeps its slope. The plate is solved on blocks of pixels, which
    smooths what is known; the differences to that are filled in by the mean of the neighbours.
    Without any known pixel all values are 0.
    """
    if not known.any():
        return np.zeros(values.shape)
    given = np.where(known, values, 0.0).astype(np.float64)
    if known.all():
        return given
    plate = _thin_plate(given, known)
    filled = plate + _membrane(np.where(known, given - plate, 0.0), known)
    bounds = given[known].min() / _BEYOND, given[known].max() * _BEYOND
    return np.where(known, given, np.clip(filled, *bounds))


def _thin_plate(values: Doubles, known: npt.NDArray[np.bool_]) -> Doubles:
    """Return the plate of least bending energy that the known values pull at, [H, W]."""
    sums, counts = _blocks(values * known, _BLOCK), _blocks(known, _BLOCK)
    height, width = counts.shape
    place = np.arange(counts.size).reshape(height, width)
    pull = counts.ravel() / _BLOCK**2
    matrix = np.diag(pull)  # of the normal equations
    differences = (
        (_TENSION, (-1, 1), (place[:, :-1], place[:, 1:])),
        (_TENSION, (-1, 1), (place[:-1], place[1:])),
        (_STIFFNESS, (1, -2, 1), (place[:, :-2], place[:, 1:-1], place[:, 2:])),
        (_STIFFNESS, (1, -2, 1), (place[:-2], place[1:-1], place[2:])),
        (2 * _STIFFNESS, (1, -1, -1, 1), (place[:-1, :-1], place[:-1, 1:], place[1:, :-1], place[1:, 1:])),
    )
    for cost, weights, places in differences:
        for a, row in zip(weights, places, strict=True):
            for b, column in zip(weights, places, strict=True):
                matrix[row.ravel(), column.ravel()] += cost * a * b  # every row stands once in `row`
    means = np.divide(sums, counts, out=np.zeros(sums.shape), where=counts > 0)
    return _enlarged(np.linalg.solve(matrix, pull * means.ravel()).reshape(height, width), values.shape)


def _enlarged(plate: Doubles, shape: tuple[int, ...]) -> Doubles:
    """Interpolate between the middles of the blocks, and go on straight beyond the outer ones."""
    for axis in (0, 1):
        if plate.shape[axis] < 2:
            plate = plate.repeat(shape[axis], axis)
            continue
        at = (np.arange(shape[axis]) + 0.5) / _BLOCK - 0.5
        first = np.clip(at.astype(np.int64), 0, plate.shape[axis] - 2)
        share = np.expand_dims(at - first, 1 - axis)
        plate = plate.take(first, axis) * (1 - share) + plate.take(first + 1, axis) * share
    return plate


def _membrane(values: Doubles, known: npt.NDArray[np.bool_]) -> Doubles:
    """Return values of which every unknown one is the mean of its four neighbours."""
    filled = _coarse_to_fine(values, known)
    for _ in range(_ROUNDS):
        around = np.pad(filled, 1, mode="edge")
        mean = 0.25 * (around[:-2, 1:-1] + around[2:, 1:-1] + around[1:-1, :-2] + around[1:-1, 2:])
        filled = np.where(known, filled, mean)
    return filled


def _coarse_to_fine(values: Doubles, known: npt.NDArray[np.bool_]) -> Doubles:
    """Fill gaps with the mean of the smallest of ever larger blocks that knows one (Gortler et al., SIGGRAPH 1996)."""
    if known.all() or not known.any():
        return values
    height, width = values.shape
    sums, counts = _blocks(values * known, 2), _blocks(known, 2)
    coarse = _coarse_to_fine(sums / np.maximum(counts, 1), counts > 0)
    return np.where(known, values, coarse.repeat(2, 0).repeat(2, 1)[:height, :width])


def _blocks(values: npt.NDArray[Any], side: int) -> npt.NDArray[Any]:
    """Return the sums of blocks of `side` x `side` pixels, those at the right and lower border of what there is."""
    height, width = values.shape
    down, across = -(-height // side), -(-width // side)
    room = ((0, down * side - height), (0, across * side - width))
    return np.asarray(np.pad(values, room).reshape(down, side, across, side).sum((1, 3)))
