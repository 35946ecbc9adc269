"""Where the capture looked: the up vector, the centre and the distance that an orbit camera starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hgs_core.base.arrays import Doubles
from hgs_core.base.errors import InputError
from hgs_core.scene.camera import Camera

__all__ = ["Viewpoint", "find_viewpoint"]


# How much a camera's own guess of the centre counts against the crossing of all optical axes. Small, so that it only
# decides along directions in which the axes are parallel.
GUESS_WEIGHT = 0.02


@dataclass(frozen=True)
class Viewpoint:
    """The common viewpoint of a capture's cameras."""

    up: tuple[float, float, float]  # unit vector: the mean of the cameras' upward directions
    center: tuple[float, float, float]  # the point the cameras look at, world units
    extent: float  # median distance of the cameras from `center`, world units, above 0
    pixel: float  # size of a pixel at that distance, world units


def find_viewpoint(cameras: Sequence[Camera], points: Doubles) -> Viewpoint:
    """Find the point nearest to all optical axes; along parallel axes, the median depth of `points` [P, 3] decides.

    Raises:
        InputError: there are no cameras.
    """
    if not cameras:
        raise InputError("cameras", "there are none", "give the capture's cameras")
    axes = np.array([camera.world_to_camera[2, :3] for camera in cameras])
    origins = np.array([camera.position for camera in cameras])
    depths = np.array([_median_depth(camera, points) for camera in cameras])
    guess = (origins + axes * np.nanmedian(depths)).mean(axis=0) if np.isfinite(depths).any() else None
    if guess is None:
        spread = float(np.linalg.norm(origins - origins.mean(axis=0), axis=1).max())
        guess = (origins + axes * (spread or 1.0)).mean(axis=0)
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]  # removes the part along each axis
    matrix = across.sum(axis=0) + GUESS_WEIGHT * len(cameras) * np.eye(3)
    target = (across @ origins[:, :, None]).sum(axis=0)[:, 0] + GUESS_WEIGHT * len(cameras) * guess
    center = np.linalg.solve(matrix, target)
    extent = float(np.median(np.linalg.norm(origins - center, axis=1))) or 1.0
    up = -np.array([camera.world_to_camera[1, :3] for camera in cameras]).mean(axis=0)
    length = float(np.linalg.norm(up))
    up = up / length if length > 1e-6 else -cameras[0].world_to_camera[1, :3]
    pixel = extent / float(np.median([(camera.fx * camera.fy) ** 0.5 for camera in cameras]))
    return Viewpoint(_triple(up), _triple(center), extent, pixel)


def _median_depth(camera: Camera, points: Doubles) -> float:
    """Return the median depth of the points in the picture; NaN if there are none."""
    pixels, depth = camera.project(points)
    inside = camera.shows(pixels, depth, beyond=0)
    return float(np.median(depth[inside])) if inside.any() else float("nan")


def _triple(vector: Doubles) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in vector)
    return x, y, z
