"""From labelled points to the first splats."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.points.point_cloud import PointCloud
from hgs_core.scene.motion import COEFFICIENTS
from hgs_core.scene.splats import DynamicSplats, Segment, StaticSplats

__all__ = ["initial_splats", "scene_extent"]

_DYNAMIC_SHARE = 0.5  # share of a point's views that must see it move
_THICKNESS = 0.1  # thickness across a surface, share of a splat's size
_HALF_LIFE = 0.75  # share of the gap between initialised frames at which opacity halves


def scene_extent(positions: npt.NDArray[np.float64]) -> float:
    """Return the radius of the camera positions [C, 3], the length that step sizes are measured in.

    1.1 times the largest distance from their mean, as in 3D Gaussian Splatting; 1 if they coincide.
    """
    radius = float(np.linalg.norm(positions - positions.mean(0), axis=1).max()) * 1.1
    return radius if radius > 1e-6 else 1.0


def initial_splats(
    points: PointCloud,
    clock: Segment[Any],
    sampled_frames: int,
    labels: str = "auto",
    opacity: float = 0.1,
    coefficients: int = COEFFICIENTS[0],
) -> tuple[StaticSplats[Tensor], DynamicSplats[Tensor]]:
    """Make one splat of every point: static, or dynamic around the moment the point was seen.

    Where the point's surface is known it is a disc that lies in it, else it is round.

    Args:
        points: labelled points.
        clock: the segment whose normalised time the splats live in.
        sampled_frames: how many moments the dynamic points were taken at, evenly over the segment.
        labels: `auto` follows the points' labels; `static` and `dynamic` make all splats alike, and a point that stands
            still then starts a dynamic splat that lives all through the segment.
        opacity: of all splats; 3D Gaussian Splatting starts at 0.1, low enough that wrong points can fade.
        coefficients: of motion, 4 or 6; those above the velocity start at zero.
    """
    still_points = points.dynamic < _DYNAMIC_SHARE
    moving = {"auto": ~still_points, "static": still_points & False, "dynamic": still_points | True}[labels]
    size = np.log(np.maximum(points.spacing, 1e-7)).astype(np.float32)
    logit = float(np.log(opacity / (1 - opacity)))

    quats = _facing(points.normal)
    scales = np.repeat(size[:, None], 3, 1)
    scales[points.normal.any(axis=1), 2] += np.float32(np.log(_THICKNESS))
    still, moved = int((~moving).sum()), int(moving.sum())
    static = StaticSplats(
        points.xyz[~moving], scales[~moving], quats[~moving], np.full(still, logit, np.float32), points.rgb[~moving]
    )
    motion = np.zeros((moved, coefficients, 3), np.float32)
    motion[:, 0] = points.xyz[moving]
    motion[:, 1] = points.velocity[moving] * np.float32(clock.end - clock.start)
    half_life = np.where(still_points[moving], 1.0, _HALF_LIFE / max(1, sampled_frames - 1))
    centers = np.array([clock.normalised(float(t)) for t in points.times[moving]], np.float32)
    dynamic = DynamicSplats(
        motion,
        np.stack([quats[moving], np.zeros((moved, 4), np.float32)], 1),
        scales[moving],
        np.full(moved, logit, np.float32),
        np.where(still_points[moving], np.float32(0.5), centers),
        np.log(np.log(2) / half_life**2).astype(np.float32),
        points.rgb[moving],
    )
    return static.map(_parameter), dynamic.map(_parameter)


def _facing(normals: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Return quaternions [P, 4] (w first) that turn the z axis to normals [P, 3] or their opposites; 1 for zeros."""
    upper = np.where(normals[:, 2:] < 0, -normals, normals)  # no turn by more than a right angle
    upper[~normals.any(axis=1)] = (0, 0, 1)
    quats = np.stack([1 + upper[:, 2], -upper[:, 1], upper[:, 0], np.zeros(len(upper), np.float32)], 1)
    return np.asarray(quats / np.linalg.norm(quats, axis=1, keepdims=True), np.float32)


def _parameter(array: npt.NDArray[np.float32]) -> Tensor:
    return torch.tensor(array, dtype=torch.float32)
