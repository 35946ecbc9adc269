"""Unit quaternions w, x, y, z; a quaternion of no length is the identity, as in rendering (docs/numerics.md)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles

__all__ = ["unit_quaternions", "units_and_norms"]

SHORTEST = 1e-12  # |q|^2 < 1e-24


def units_and_norms(quaternions: NDArray[np.floating[Any]]) -> tuple[Doubles, Doubles]:
    """Return unit quaternions [N, 4] in float64, and the norms [N, 1] that they had: 1 for those of no length."""
    given = np.asarray(quaternions, np.float64)
    norms = np.linalg.norm(given, axis=1, keepdims=True)
    short = norms < SHORTEST
    norms = np.where(short, 1.0, norms)
    return np.where(short, (1.0, 0.0, 0.0, 0.0), given / norms), norms


def unit_quaternions(quaternions: NDArray[np.floating[Any]]) -> Doubles:
    """Return quaternions [N, 4] at unit length, in float64."""
    return units_and_norms(quaternions)[0]
