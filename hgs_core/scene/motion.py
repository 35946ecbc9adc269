"""The position polynomial of dynamic splats (docs/numerics.md, "Time"), for numpy and torch alike."""

from __future__ import annotations

import math
from typing import Any, TypeVar

__all__ = ["COEFFICIENTS", "coefficients_of_order", "position", "recentred"]

A = TypeVar("A")

COEFFICIENTS = (4, 6)
"""How many coefficients the splats of a set may have: a cubic, or a polynomial of the fifth order."""


def coefficients_of_order(order: int) -> int:
    """Return the number of coefficients in which a polynomial of this order is kept: 4 or 6.

    Raises:
        ValueError: an order above 5.
    """
    for count in COEFFICIENTS:
        if order < count:
            return count
    raise ValueError(f"motion of order {order}: the highest order is {COEFFICIENTS[-1] - 1}")


def position(motion: A, offset: Any) -> A:
    """Return sum_k motion[..., k, :] offset^k, [..., 3], by Horner's rule.

    Args:
        motion: [..., K, 3] coefficients, constant first.
        offset: time from the splat's centre; a number, or an array that broadcasts with [..., 3].
    """
    m: Any = motion
    *lower, result = (m[..., k, :] for k in range(m.shape[-2]))
    for coefficient in reversed(lower):
        result = coefficient + offset * result
    return result  # type: ignore[no-any-return]


def recentred(motion: A, by: Any) -> list[A]:
    """Return the coefficients, K times [..., D], of the same path about a centre that is later by `by`.

    Args:
        motion: [..., K, D] coefficients, constant first.
        by: a number, or an array that broadcasts with [..., D].
    """
    m: Any = motion
    count = m.shape[-2]
    return [sum(math.comb(j, k) * by ** (j - k) * m[..., j, :] for j in range(k, count)) for k in range(count)]
