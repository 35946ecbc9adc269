"""Quantisers: from floats to integer codes with a declared error bound, and the exact arithmetic back.

Every decoded value is `origin + code * step` in IEEE binary32, each operation rounded to nearest; numpy's float32 and
JavaScript's Math.fround give the same bits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "MAX_BITS",
    "Affine",
    "achievable",
    "fit",
    "fit_rotation",
    "float32_above",
    "largest_component",
    "quats_from_smallest_three",
]

MAX_BITS = 24  # codes are exact in binary32

Doubles = NDArray[np.float64]
Floats = NDArray[np.float32]
Codes = NDArray[np.uint32]

# A rotation's chordal error is at most sqrt(12) half steps: sqrt(3) from the stored components and 3 from the rebuilt
# one, whose slope is at most sqrt(3) because it is at least 1/2. A little more for rounding.
CHORD_PER_HALF_STEP = 3.465


@dataclass(frozen=True)
class Affine:
    """A uniform grid: one step, one origin per component, codes below 2^bits."""

    step: float  # exact in float32
    origin: tuple[float, ...]  # exact in float32
    bits: int
    bound: float  # largest error of any value it was fitted to; exact in float32

    def encode(self, values: Doubles) -> Codes:
        """Return the nearest codes [N, C] of values [N, C]."""
        codes = np.rint((values - self.origin) / self.step)
        return np.clip(codes, 0, (1 << self.bits) - 1).astype(np.uint32)

    def decode(self, codes: Codes) -> Floats:
        """Return the values [N, C] of codes, in float32 arithmetic; may overflow to infinity for a damaged grid."""
        with np.errstate(over="ignore", invalid="ignore"):
            products: Floats = codes.astype(np.float32) * np.float32(self.step)
            return products + np.array(self.origin, np.float32)


def achievable(values: Doubles, bound: float) -> float:
    """Return `bound`, or the least larger one that 24-bit codes and float32 arithmetic can keep over these values."""
    largest, span = _reach(values)
    return max(bound, 4 * _rounding(largest, span), span / (1 << (MAX_BITS - 1)))


def fit(values: Doubles, bound: float, *, zero: bool = False) -> Affine:
    """Return a grid that keeps values [N, C], N >= 1, within `bound`, or within `achievable` if that is larger.

    With `zero`, the components share an origin and zero is exactly a grid point.
    """
    largest, span = _reach(values)
    bound = float32_above(achievable(values, bound))
    step = _float32_below(
        2 * (bound - _rounding(largest, span)) * (1 - 1e-4)
    )  # the last factor covers a zero-centred origin
    low = values.min(axis=0)
    if zero:
        below = math.ceil(max(0.0, -float(low.min()) / step - 0.5))
        # 128 modulo 256, so that small values of both signs share their high bytes.
        code_of_zero = below + (128 - below) % 256 if below else 0
        origin = (-float(np.float32(code_of_zero) * np.float32(step)),) * values.shape[1]
    else:
        origin = tuple(float(np.float32(x)) for x in low)
    top = float(np.rint((values - origin) / step).max())
    return Affine(step, origin, max(1, int(top).bit_length()), bound)


def fit_rotation(error: float) -> Affine:
    """Return the grid of the three smaller components of unit quaternions with a chordal error of at most `error`.

    The codes 0 .. 2^bits - 2 span [-1/sqrt(2), 1/sqrt(2)], zero included.
    """
    bits = 3
    while bits < 20 and CHORD_PER_HALF_STEP * math.sqrt(0.5) / ((1 << bits) - 2) > error:
        bits += 1
    half = (1 << (bits - 1)) - 1
    step = float(np.float32(math.sqrt(0.5) / half))
    origin = -float(np.float32(half) * np.float32(step))
    return Affine(step, (origin,) * 3, bits, float32_above(CHORD_PER_HALF_STEP * step / 2))


def largest_component(quats: Doubles) -> tuple[NDArray[np.uint32], Doubles]:
    """Return the index [N] of the largest component of unit quaternions [N, 4], and the other three [N, 3] in order.

    The sign is chosen so that the largest component is positive.
    """
    index = np.abs(quats).argmax(axis=1)
    rows = np.arange(len(quats))
    sign = np.where(quats[rows, index] < 0, -1.0, 1.0)
    others = np.array([[j for j in range(4) if j != i] for i in range(4)])[index]
    return index.astype(np.uint32), quats[rows[:, None], others] * sign[:, None]


def quats_from_smallest_three(index: NDArray[np.uint32], three: Floats) -> Floats:
    """Return quaternions [N, 4]: the missing component is sqrt(max(0, 1 - (a a + b b + c c))) in binary64."""
    a, b, c = three.astype(np.float64).T
    with np.errstate(over="ignore"):
        largest = np.sqrt(np.maximum(0.0, 1.0 - (a * a + b * b + c * c))).astype(np.float32)
    quats = np.empty((len(three), 4), np.float32)
    rows = np.arange(len(three))
    others = np.array([[j for j in range(4) if j != i] for i in range(4)])[index]
    quats[rows[:, None], others] = three
    quats[rows, index] = largest
    return quats


def _reach(values: NDArray[np.floating[Any]]) -> tuple[float, float]:
    """Return the largest magnitude and the largest span of any component."""
    return float(np.abs(values).max()), float((values.max(axis=0) - values.min(axis=0)).max())


def _rounding(largest: float, span: float) -> float:
    """Bound what float32 arithmetic adds to the error of `origin + code * step`."""
    return math.ldexp(largest, -22) + math.ldexp(span, -22) + 1e-37


def float32_above(x: float) -> float:
    """Return the least float32 number that is not below `x`."""
    y = np.float32(x)
    return float(y) if float(y) >= x else float(np.nextafter(y, np.float32(np.inf)))


def _float32_below(x: float) -> float:
    y = np.float32(x)
    return float(y) if float(y) <= x else float(np.nextafter(y, np.float32(0)))
