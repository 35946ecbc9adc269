"""Weighted least-squares fits of polynomials to paths, wherever on the axis of time these lie."""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Doubles
from hgs_core.scene.motion import recentred

__all__ = ["polynomial_fit", "powers"]

RIDGE = 1e-12  # share of the mean square of a power
LEAST_UNIT = 1e-6  # half of a range, at least: what is shorter is an instant


def powers(offsets: Doubles, order: int) -> Doubles:
    """Return the powers 0 to `order` of offsets [N, J], [N, J, order + 1]."""
    return np.stack([offsets**k for k in range(order + 1)], axis=2)


def polynomial_fit(offsets: Doubles, order: int, goal: Doubles, weights: Doubles) -> Doubles:
    """Return the coefficients [N, order + 1, D] of the powers of `offsets` [N, J] that fit `goal` [N, J, D] best.

    Squared errors are weighed by `weights` [N, J]. The fit is made in powers of how far offsets are from the middle of
    their range, in halves of it, and then expanded: a splat whose centre lies far outside of what is shown of it has
    offsets whose own powers can hardly be told apart. Ranges in which none can be get the least coefficients.
    """
    first, last = offsets.min(axis=1), offsets.max(axis=1)
    middle, unit = (first + last) / 2, np.maximum((last - first) / 2, LEAST_UNIT)
    basis = powers((offsets - middle[:, None]) / unit[:, None], order)
    weighted = np.swapaxes(basis * weights[..., None], 1, 2)
    matrix = weighted @ basis
    ridge = RIDGE * np.trace(matrix, axis1=1, axis2=2)[:, None, None] * np.eye(order + 1)
    near = np.linalg.solve(matrix + ridge, weighted @ goal) / unit[:, None, None] ** np.arange(order + 1)[:, None]
    return np.stack(recentred(near, -middle[:, None]), axis=1)
