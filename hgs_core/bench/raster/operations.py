"""How many floating-point operations one evaluation of a splat at a pixel counts for.

Counted are the additions, multiplications and minima that the formulas of docs/numerics.md, "Compositing", need at
every pixel, an FMA as two; not what a row or a column of pixels shares, comparisons, masks, loads and stores.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Operations"]

EXPONENT = 3  # a square taken from a constant of the row; its root is one of the column plus one of the row
EXP2 = 13  # rounding to a whole number 3, a polynomial of degree 5 for the rest 10
BLEND = 3  # min with 0.99, T alpha, T - T alpha
COLOUR = 6  # rgb += weight colour
ALONG = 5  # g . colour
REST = 2  # S - weight (g . colour)
D_ALPHA = 8  # 1 - alpha, its reciprocal (an estimate and a Newton step: 4), T (g . colour) - S / (1 - alpha)
MOMENTS = 6  # h = alpha dL/dalpha, its sum, and those of h dy and h dy^2
GRAD_COLOUR = 6  # sums of weight g


@dataclass(frozen=True)
class Operations:
    """Floating-point operations per evaluation."""

    forward: int = EXPONENT + EXP2 + BLEND + COLOUR
    backward: int = EXPONENT + EXP2 + BLEND + ALONG + REST + D_ALPHA + MOMENTS + GRAD_COLOUR
