"""Uniform grids: from numbers to integer codes and back, in the arithmetic of docs/format.md."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats

__all__ = [
    "MAX_BITS",
    "MAX_ZERO",
    "Grid",
    "eased",
    "fitting_grid",
    "float32_above",
    "float32_below",
    "uneased",
    "unit_quats",
]

MAX_BITS = 24
MAX_ZERO = 1 << 28  # keeps (code - zero) * step exact in binary64, so that it is rounded once

_EXACT = 1 << 24  # whole numbers up to it are exact in binary32

Codes = NDArray[np.uint32]


class Grid(NamedTuple):
    """One step for all components, one zero per component: value = (code - zero) * step, codes below 2^bits."""

    step: float  # exact in float32, above 0
    zeros: tuple[int, ...]
    bits: int

    def largest(self) -> int:
        """Return the upper bound of |code - zero|."""
        return max(max(self.zeros), -min(self.zeros)) + (1 << self.bits)

    def decode(self, codes: NDArray[np.unsignedinteger[Any]]) -> Floats:
        """Return the values [N, C] of codes [C, N]; infinite, with a warning, where a damaged grid overflows."""
        values = np.empty(codes.shape[::-1], np.float32)
        if self.largest() <= _EXACT:
            # Both factors are exact in binary32, so its product is the exact one rounded once: the same bits for less.
            whole = np.subtract(codes, np.array(self.zeros, np.float32)[:, None], dtype=np.float32)
            np.multiply(whole, np.float32(self.step), out=values.T)
        else:
            values.T[...] = (codes - np.array(self.zeros, np.float64)[:, None]) * self.step
        return values


def fitting_grid(numbers: NDArray[np.int64], step: float, *, common: bool = False) -> tuple[Grid, Codes]:
    """Return the grid of `step` and the codes for whole numbers [N, C], N >= 1: multiples of the step.

    With `common` the components share their zero, so that a chain of their differences is small.

    Raises:
        ValueError: the numbers span 2^24 steps or more, or lie farther than 2^28 from zero.
    """
    low = numbers.min(axis=0)
    if common:
        low = np.full_like(low, low.min())
    codes = numbers - low
    bits = max(1, int(codes.max()).bit_length())
    if bits > MAX_BITS or int(np.abs(low).max()) > MAX_ZERO:
        raise ValueError("the numbers are too many steps apart, or too far from zero")
    return Grid(step, tuple(-int(x) for x in low), bits), codes.astype(np.uint32)


def unit_quats(vector: Floats, out: Floats | None = None) -> Floats:
    """Return quaternions [N, 4] of vector parts x, y, z [N, 3]: w = sqrt(max(0, 1 - (x x + y y + z z))).

    They are written to `out` if it is given.
    """
    quats = np.empty((len(vector), 4), np.float32) if out is None else out
    squares = vector.T.astype(np.float64, order="C")
    squares *= squares
    w = squares[0] + squares[1]
    w += squares[2]
    np.subtract(1.0, w, out=w)
    quats[:, 0] = np.sqrt(np.maximum(w, 0.0, out=w), out=w)
    quats[:, 1:] = vector
    return quats


def eased(x: NDArray[np.floating[Any]]) -> Doubles:
    """Return x x (3 - 2 x) in binary64 of numbers limited to [0, 1]: the opacity of a stored number.

    Equal steps of x are finer steps of opacity near 0, where its ratio counts, and near 1.
    """
    limited = np.minimum(np.maximum(x.astype(np.float64), 0.0), 1.0)
    return limited * limited * (3.0 - 2.0 * limited)


def uneased(opacity: Doubles) -> Doubles:
    """Return the x in [0, 1] that `eased` takes to `opacity`."""
    return np.asarray(0.5 - np.sin(np.arcsin(1.0 - 2.0 * np.clip(opacity, 0.0, 1.0)) / 3.0))


def float32_above(x: float) -> float:
    """Return the least float32 number that is not below `x`."""
    y = np.float32(x)
    return float(y) if float(y) >= x else float(np.nextafter(y, np.float32(np.inf)))


def float32_below(x: float) -> float:
    """Return the largest float32 number that is not above `x`."""
    y = np.float32(x)
    return float(y) if float(y) <= x else float(np.nextafter(y, np.float32(-np.inf)))
