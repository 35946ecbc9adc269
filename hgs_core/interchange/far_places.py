"""Places far from the origin, such as map coordinates: 32-bit numbers hold them once their middle is subtracted."""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.interchange.changes import Action, Change

__all__ = ["coarse", "middle_if_far", "moved"]

FAR = 100.0  # extents of the scene; there 32 bits leave less than 17 for the scene itself
FAR_ALONE = 1e3  # world units, of a scene without extent
MOST = 80.0  # % of the splats for the extent


def middle_if_far(places: Doubles) -> Doubles | None:
    """Return the middle of those places [N, 3] that are finite, in round numbers, if it is far from the origin."""
    finite = places[np.isfinite(places).all(axis=1)]
    if not len(finite):
        return None
    low, middle, high = np.percentile(finite, ((100 - MOST) / 2, 50, (100 + MOST) / 2), axis=0)
    extent = float((high - low).max())
    if not float(np.abs(middle).max()) > (FAR * extent if extent > 0 else FAR_ALONE):
        return None
    step = 10.0 ** np.floor(np.log10(extent)) if extent > 1e-30 else 1.0
    middle = np.round(middle / step) * step + 0.0  # no -0
    return middle if np.isfinite(middle).all() and middle.any() else None


def moved(middle: Doubles) -> Change:
    """Return the change that subtracting a middle is."""
    about = ", ".join(f"{value:.17g}" for value in middle)
    return Change.whole(Action.REPLACED, "places", f"by those about ({about}), since 32-bit numbers cannot hold both")


def coarse(places: Doubles, log_scales: Floats) -> tuple[Change, ...]:
    """Return the change that a file made which holds `places` [N, 3] in steps larger than half a splat, if it did.

    `log_scales` [N, 3] are the splats' sizes.
    """
    finite = places[np.isfinite(places).all(axis=1)]
    values = [np.unique(axis) for axis in finite.T]
    steps = [float(np.diff(one).min()) for one in values if 1 < len(one) < len(finite)]
    with np.errstate(over="ignore"):
        size = float(np.exp(np.median(log_scales.max(axis=1)))) if len(log_scales) else 0.0
    if not steps or max(steps) <= size / 2:
        return ()
    reason = f"the file holds them in steps of {max(steps):.2g}; export it with 64-bit places, or less its middle"
    return (Change.whole(Action.ROUNDED, "places", reason),)
