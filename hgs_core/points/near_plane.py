"""Near planes: how close to a camera a splat may be drawn."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hgs_core.scene.camera import Camera

__all__ = ["with_near_planes"]

_MEDIAN_SHARE = 0.08  # least share of a camera's median depth
_NEAREST_SHARE = 0.6  # share of the depth of the nearest points in view, but for one in a hundred


def with_near_planes(cameras: Sequence[Camera], points: npt.NDArray[np.float32]) -> tuple[Camera, ...]:
    """Return the cameras with near planes that suit the scene.

    In a dome every camera looks past the others, and the body of one is a surface like any other: seen from that
    camera's own place it fills the picture. And what a camera shows and too few others do, training explains by fog in
    front of that camera alone. A near plane at 60 % of the depth of the nearest of the points [P, 3] in view, at least
    8 % of their median, leaves both out, at any scale of the world.
    """
    planes = np.array([_near_plane(camera, points) for camera in cameras])
    if np.isnan(planes).all():
        return tuple(cameras)
    planes = np.where(np.isnan(planes), np.nanmedian(planes), planes)
    return tuple(dataclasses.replace(camera, near=float(near)) for camera, near in zip(cameras, planes, strict=True))


def _near_plane(camera: Camera, points: npt.NDArray[np.float32]) -> float:
    pixels, depth = camera.project(points)
    with np.errstate(invalid="ignore"):
        seen = (depth > 0) & (pixels >= 0).all(1) & (pixels < (camera.width, camera.height)).all(1)
    if not seen.any():
        return np.nan
    return float(max(_MEDIAN_SHARE * np.median(depth[seen]), _NEAREST_SHARE * np.percentile(depth[seen], 1)))
