"""The hull of motion: points inside it, and dynamic splats that have left it.

They start in the visual hull of the moving pixels, where most views see something move. Those that training has pushed
out of it since, or whose motion carries them out, show nothing that moves: at best they repair what stands still, a few
frames at a time, and to a camera between the training cameras they are flecks in empty space.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.decompose.background import sample_frames
from hgs_core.points.point_labels import label_points
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats
from hgs_core.scene.temporal import evaluate

__all__ = ["ever_inside", "outside_moving_hull"]

_INSIDE_SHARE = 0.5  # mean share of the views that must see something move there
_LOOKED_AT_MOMENTS = 16  # moments of the segment at which something still is looked for in the hull
# Normalised time to half the opacity; what lives longer may be a restless static, outside of masks.
_BRIEF_HALF_LIFE = 0.25
_LIFE_MOMENTS = (-1.0, 0.0, 1.0)  # halving times from the centre of a life


def ever_inside(
    xyz: npt.NDArray[np.float32],
    cameras: Sequence[Camera],
    frames: int,
    moving: Callable[[int], Sequence[npt.NDArray[np.bool_]]],
) -> npt.NDArray[np.bool_]:
    """Return [P] at which places [P, 3] half of the views see something move at one of a few moments.

    Args:
        xyz: the places.
        cameras: whose masks `moving` gives.
        frames: of the segment.
        moving: gives the masks [H, W] of all cameras at a frame of the segment.
    """
    inside = np.zeros(len(xyz), np.bool_)
    for frame in sample_frames(frames, _LOOKED_AT_MOMENTS):
        inside |= label_points(cameras, moving(frame), xyz) >= _INSIDE_SHARE
    return inside


def outside_moving_hull(
    dynamic: DynamicSplats[Tensor],
    cameras: Sequence[Camera],
    frames: int,
    moving: Callable[[int], Sequence[npt.NDArray[np.bool_]]],
) -> npt.NDArray[np.bool_]:
    """Return a mask [M] of dynamic splats that live briefly and outside of the hull of motion.

    A splat is looked at in the middle of its life and where its opacity has halved, as far as the segment goes.

    Args:
        dynamic: the splats.
        cameras: whose masks `moving` gives.
        frames: of the segment, evenly over normalised time.
        moving: gives the masks [H, W] of all cameras at a frame of the segment.
    """
    arrays = dynamic.map(lambda array: array.detach().numpy())
    half_life = np.sqrt(np.log(2) / np.exp(arrays.time_log_precisions.astype(np.float64)))
    share, looked = np.zeros(len(dynamic)), np.zeros(len(dynamic))
    last = max(1, frames - 1)
    moments = np.stack([arrays.time_centers + part * half_life for part in _LIFE_MOMENTS])  # [3, M]
    at = np.where((moments >= 0) & (moments <= 1), np.rint(moments * last), -1).astype(np.int64)
    for frame in np.unique(at[at >= 0]):
        rows = np.flatnonzero((at == frame).any(0))
        xyz, _, _ = evaluate(arrays.take(rows), float(frame / last))
        share[rows] += label_points(cameras, moving(int(frame)), xyz)
        looked[rows] += 1
    return np.asarray((half_life < _BRIEF_HALF_LIFE) & (looked > 0) & (share < _INSIDE_SHARE * looked))
