"""Opacities and the logits that splats store in their place."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats

__all__ = ["logits_of", "logits_of_any", "opacities_of"]

_LEAST = 1e-6  # least opacity with a logit here


def opacities_of(logits: NDArray[np.floating[Any]]) -> Doubles:
    """Return the sigmoid of logits, in float64: exact from 0 at -inf to 1 at +inf, without overflow."""
    return np.asarray(np.exp(-np.logaddexp(0.0, -np.asarray(logits, np.float64))))


def logits_of(opacities: NDArray[np.floating[Any]]) -> Floats:
    """Return the logits of opacities between 0 and 1, both excluded, as float32."""
    return np.log(opacities / (1 - opacities)).astype(np.float32)


def logits_of_any(opacities: NDArray[np.floating[Any]]) -> Floats:
    """Return the logits of opacities from 0 to 1: those beyond 0.000001 to 0.999999 count as these."""
    return logits_of(np.clip(np.asarray(opacities, np.float64), _LEAST, 1 - _LEAST))
