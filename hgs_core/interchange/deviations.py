"""Standard deviations, which some formats store in place of their logarithms."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.interchange.changes import Action, Change

__all__ = ["deviations_limited", "deviations_of", "log_scales_of"]

_LEAST, _MOST = -80.0, 80.0  # log-scales whose exponentials are normal float32 numbers


def deviations_of(log_scales: Floats) -> Floats:
    """Return standard deviations [N, 3]; beyond e^-80 to e^80 they are limited to these."""
    return np.asarray(np.exp(np.clip(log_scales, _LEAST, _MOST)), np.float32)


def deviations_limited(log_scales: Floats) -> Change:
    """Return the changes of `deviations_of`."""
    beyond = (log_scales < _LEAST) | (log_scales > _MOST)
    return Change.where(Action.LIMITED, "scale", beyond, f"to e^{_LEAST:g} to e^{_MOST:g}")


def log_scales_of(deviations: NDArray[np.floating[Any]]) -> Floats:
    """Return the logarithms of standard deviations [N, 3]: of 0 minus infinity, of negative ones no number."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.log(deviations), np.float32)
