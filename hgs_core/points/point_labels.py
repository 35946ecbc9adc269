"""Which points move: the verdict of the views that see them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["label_points", "mean_over_views"]


def label_points(
    cameras: Sequence[Camera],
    masks: Sequence[npt.NDArray[np.bool_]],  # [H, W] of each camera, at the moment of the points
    xyz: npt.NDArray[np.floating[Any]],  # [P, 3]
    seen: npt.NDArray[np.bool_] | None = None,  # [P, C] views that see each point; None: all whose picture it falls in
) -> npt.NDArray[np.float32]:
    """Return [P] the share of moving masks among the views of a point, 0..1; 0 if no view sees it."""
    return mean_over_views(cameras, masks, xyz, seen)


def mean_over_views(
    cameras: Sequence[Camera],
    values: Sequence[npt.NDArray[Any]],  # [H, W] of each camera
    xyz: npt.NDArray[np.floating[Any]],  # [P, 3]
    seen: npt.NDArray[np.bool_] | None = None,  # [P, C] as in `label_points`
) -> npt.NDArray[np.float32]:
    """Return [P] the mean value of the pixels that show a point; 0 if no view sees it."""
    total = np.zeros(len(xyz), np.float32)
    views = np.zeros(len(xyz), np.float32)
    for column, (camera, picture) in enumerate(zip(cameras, values, strict=True)):
        rows, pixels = pixels_inside(camera, xyz)
        if seen is not None:
            kept = seen[rows, column]
            rows, pixels = rows[kept], pixels[kept]
        views[rows] += 1
        total[rows] += picture[pixels[:, 1], pixels[:, 0]]
    return np.asarray(total / np.maximum(views, 1), np.float32)
