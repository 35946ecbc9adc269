"""The equations of time on numpy arrays: when a dynamic splat lives, and where it is (docs/numerics.md, "Time")."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.scene.motion import position
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splats import DynamicSplats

__all__ = ["evaluate", "lifetime"]


def lifetime(dynamic: DynamicSplats[NDArray[np.floating[Any]]]) -> tuple[Doubles, Doubles]:
    """Return the first and the last normalised time at which each splat's opacity is 1/255 or more, ([M], [M]).

    |t - mu| <= sqrt(ln(255 sigma) / s). A splat with sigma < 1/255 never lives: its start is +inf and its end -inf.
    Where s underflows to zero the splat always lives: (-inf, +inf).
    """
    logit = np.asarray(dynamic.opacity_logits, np.float64)
    center = np.asarray(dynamic.time_centers, np.float64)
    visibility = np.log(255.0) - np.logaddexp(0.0, -logit)  # ln(255 sigma)
    with np.errstate(over="ignore"):
        precision = np.exp(np.asarray(dynamic.time_log_precisions, np.float64))
    visible = visibility >= 0
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.sqrt(np.where(visible, visibility, 0.0) / precision)
    radius = np.where(precision == 0, np.inf, radius)
    return np.where(visible, center - radius, np.inf), np.where(visible, center + radius, -np.inf)


def evaluate(
    dynamic: DynamicSplats[NDArray[np.floating[Any]]], time: float | Doubles
) -> tuple[Doubles, Doubles, Doubles]:
    """Return positions [M, 3], unit quaternions [M, 4] and opacities [M] at normalised `time`, in float64.

    `time` is one moment, or one per splat [M]. A rotation that passes through zero is the identity there.
    """
    d = time - np.asarray(dynamic.time_centers, np.float64)
    motion = np.asarray(dynamic.motion, np.float64)
    rotation = np.asarray(dynamic.rotation, np.float64)
    step = d[:, None]
    positions = position(motion, step)
    quats = rotation[:, 0] + step * rotation[:, 1]
    quats = unit_quaternions(quats)
    sigma = opacities_of(dynamic.opacity_logits)
    log_precision = np.asarray(dynamic.time_log_precisions, np.float64)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        exponent = np.exp(log_precision + 2 * np.log(np.abs(d)))  # s d^2, no overflow before the product
    fade = np.exp(-np.where(d == 0, 0.0, exponent))
    return positions, quats, sigma * fade
