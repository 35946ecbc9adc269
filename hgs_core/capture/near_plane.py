"""Near planes: how close to a camera a splat may be drawn."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hgs_core.camera import Camera

__all__ = ["with_near_planes"]

_SHARE = 0.08  # of the median depth that a camera sees


def with_near_planes(cameras: Sequence[Camera], points: npt.NDArray[np.float32]) -> tuple[Camera, ...]:
    """Return the cameras with near planes that suit the scene.

    In a dome every camera looks past the others, and the body of one is a surface like any other: seen from that
    camera's own place it fills the picture. A near plane at 8 % of the median depth of the points [P, 3] in view
    leaves it out, at any scale of the world.
    """
    medians = np.array([_median_depth(camera, points) for camera in cameras])
    if np.isnan(medians).all():
        return tuple(cameras)
    medians = np.where(np.isnan(medians), np.nanmedian(medians), medians)
    return tuple(
        dataclasses.replace(camera, near=float(_SHARE * depth)) for camera, depth in zip(cameras, medians, strict=True)
    )


def _median_depth(camera: Camera, points: npt.NDArray[np.float32]) -> float:
    pixels, depth = camera.project(points)
    with np.errstate(invalid="ignore"):
        seen = (depth > 0) & (pixels >= 0).all(1) & (pixels < (camera.width, camera.height)).all(1)
    return float(np.median(depth[seen])) if seen.any() else np.nan
