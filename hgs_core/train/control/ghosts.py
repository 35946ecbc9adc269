"""Ghosts: lives are cut off where nothing moves, before a thing appears and after it vanishes.

A dynamic splat fades as a Gaussian of time, and one that began wide, around a moment of initialisation, reaches far
beyond an abrupt event. Gradients shorten it slowly, because the same width is what shows the thing between the events.
The masks know better: where nothing moves and the picture is wrong, a dynamic splat should not be visible.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.base.arrays import Mask
from hgs_core.points.point_labels import label_points
from hgs_core.scene.camera import Camera
from hgs_core.scene.motion import recentred
from hgs_core.scene.splats import DynamicSplats
from hgs_core.scene.temporal import evaluate

__all__ = ["visible_where_still", "with_lives_shortened"]

_VISIBLE_OPACITY = 0.02  # opacity from which on a splat is looked at
_WRONG_LEVELS = 15  # levels of 255: a ghost is faint, so less than what births call wrong
_VIEW_SHARE = 0.5  # share of the views
_FINAL_OPACITY_SHARE = 0.05  # share of a splat's peak opacity left at the ends of its life


def visible_where_still(
    dynamic: DynamicSplats[Tensor],
    cameras: Sequence[Camera],
    moment: float,  # normalised time
    moving: Sequence[Mask],  # [H, W] what moves in the cameras' pictures
    errors: Sequence[npt.NDArray[np.float32]],  # [H, W] how wrong the scene is there, levels of 255
) -> Mask:
    """Return [M] which splats are visible at a moment where half of the views see nothing move and a wrong picture.

    Both must hold. A splat on something still that is dynamic without need is as it should be when nothing moves.
    """
    places, _, opacities = evaluate(dynamic.map(lambda array: array.detach().numpy()), moment)
    haunted = [~mask & (error > _WRONG_LEVELS) for mask, error in zip(moving, errors, strict=True)]
    ghost = np.zeros(len(dynamic), np.bool_)
    visible = np.flatnonzero(opacities >= _VISIBLE_OPACITY)
    ghost[visible] = label_points(cameras, haunted, places[visible]) >= _VIEW_SHARE
    return ghost


def with_lives_shortened(
    dynamic: DynamicSplats[Tensor], moments: npt.NDArray[np.float64], ghosts: Mask
) -> tuple[DynamicSplats[Tensor], Mask]:
    """Return splats with lives cut off where they would be ghosts, and a mask [M] of the changed ones.

    A life is the time in which opacity is at least a twentieth of its peak. It is cut at the nearest moments, before
    and after the one at which the splat is most opaque and no ghost, at which it is one; path and turning stay the same
    functions of time. A splat that is a ghost whenever it is visible stays as it is: its masks may be wrong.

    Args:
        dynamic: the splats, float32 on the CPU.
        moments: [K] normalised times, ascending.
        ghosts: [K, M] as `visible_where_still` says.
    """
    center = dynamic.time_centers.double().numpy()
    log_precision = dynamic.time_log_precisions.double().numpy()
    reach = np.sqrt(-math.log(_FINAL_OPACITY_SHARE)) * np.exp(-0.5 * log_precision)
    first, last = center - reach, center + reach
    away = np.where(ghosts, np.inf, np.abs(moments[:, None] - center))
    best = away.argmin(0)
    inside = np.isfinite(away.min(0)) & (moments[best] > first) & (moments[best] < last)
    before = np.where(ghosts & (moments[:, None] < moments[best]), moments[:, None], -np.inf).max(0)
    after = np.where(ghosts & (moments[:, None] > moments[best]), moments[:, None], np.inf).min(0)
    start, end = np.maximum(first, before), np.minimum(last, after)
    changed = inside & ((start > first) | (end < last))
    middle = np.where(changed, 0.5 * (start + end), center)
    half = np.where(changed, 0.5 * (end - start), reach)
    result = _shifted(dynamic, torch.from_numpy(middle - center))
    precision = np.where(changed, math.log(-math.log(_FINAL_OPACITY_SHARE)) - 2 * np.log(half), log_precision)
    return dataclasses.replace(result, time_log_precisions=torch.from_numpy(precision).float()), changed


def _shifted(dynamic: DynamicSplats[Tensor], by: Tensor) -> DynamicSplats[Tensor]:
    """Return the same paths and turns around centres that are later by [M] normalised time."""
    motion, rotation, d = dynamic.motion.double(), dynamic.rotation.double(), by[:, None]
    return dataclasses.replace(
        dynamic,
        motion=torch.stack(recentred(motion, d), 1).float(),
        rotation=torch.stack(recentred(rotation, d), 1).float(),
        time_centers=(dynamic.time_centers.double() + by).float(),
    )
