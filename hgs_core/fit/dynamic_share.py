"""The share of coarseness for dynamic splats with which moving pixels keep the budget in the fewest bytes."""

from __future__ import annotations

import dataclasses

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.fit.encoding_loss import Decibels, Loss
from hgs_core.scene.splats import HybridScene

__all__ = ["dynamic_share"]

SHARES = 2.0 ** -np.linspace(0.0, 2.0, 41)  # candidates: from equal coarseness to a quarter
DYNAMIC_BYTES = 2.5  # further bytes of a dynamic splat for less coarseness, over a static one's
WHOLE_LEFT_AFTER_TUNING = 0.65  # share of whole pictures' loss left by fine-tuning; moving pixels gain next to nothing
LEAST_PART = 1e-3  # least share of a loss for either set


def dynamic_share(
    scene: HybridScene[Floats], decoded: HybridScene[Floats], loss: Loss, lost: Decibels, *, tuned: bool = False
) -> float:
    """Return the coarseness of dynamic splats over that of static ones with which a budget takes the fewest bytes.

    `decoded` is `scene` as one coarseness codes it, which costs `lost`. The share is 1 where moving pixels lose no
    more than whole pictures. Elsewhere it follows from what the dynamic splats alone make of both losses: each set's
    part grows with the square of its coarseness, and its bytes fall with the logarithm.
    `tuned` says that the scene will be trained further.
    """
    if lost.moving is None or lost.moving <= max(lost.whole, 0.0):
        return 1.0
    alone = loss.of(dataclasses.replace(scene, segments=decoded.segments))
    assert alone.moving is not None
    squares = SHARES**2
    of_whole = _at_shares(lost.whole, alone.whole, squares) * (WHOLE_LEFT_AFTER_TUNING if tuned else 1.0)
    of_moving = _at_shares(lost.moving, alone.moving, squares)
    log_coarseness = -0.5 * np.log(np.maximum(of_whole, of_moving))
    dynamic = DYNAMIC_BYTES * decoded.dynamic_splats
    saved = (len(decoded.static) + dynamic) * log_coarseness + dynamic * np.log(SHARES)
    return float(SHARES[np.argmax(saved)])


def _at_shares(both: float, dynamic: float, squares: Doubles) -> Doubles:
    """Return the loss of both sets at the given squares of shares; dynamic splats make `dynamic` of it at 1."""
    least = LEAST_PART * max(both, 1e-9)
    part = min(max(dynamic, least), max(both, 1e-9) - least)
    return max(both, 1e-9) - part + part * squares
