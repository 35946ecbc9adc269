"""Rigs of few cameras, far apart: no two see the same side of anything, and features have no partners."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hgs_core.base.arrays import Doubles
from hgs_core.scene.camera import FAR_APART, Camera, neighbour_angle

__all__ = ["LONG", "angle_to_next", "level", "need_hulls", "stand_far_apart", "vertical_of"]

LONG = 10_000
"""Iterations of a long training: it has time to learn by the pictures alone."""

_NEAR_ENOUGH = 55.0  # degrees to the next camera, up to which long trainings find places without hulls
_FEWEST, _MOST = 3, 12  # cameras: two see no hull worth having, and more leave no room for such angles


def angle_to_next(cameras: Sequence[Camera]) -> float:
    """Return the angle from a camera to the nearest other, degrees, seen from their common target: the median.

    Infinity for a single camera, and where no place is in front of all.
    """
    positions = np.array([camera.position for camera in cameras])
    axes = np.array([camera.world_to_camera[2, :3] for camera in cameras])
    across = np.eye(3) - axes[:, :, None] * axes[:, None, :]
    place = np.linalg.lstsq(across.sum(0), (across @ positions[:, :, None]).sum(0)[:, 0], rcond=1e-6)[0]
    out = positions - place
    out /= np.maximum(np.linalg.norm(out, axis=1), 1e-12)[:, None]
    if len(cameras) < 2 or (out * axes).sum(1).max() > 0:
        return float("inf")
    return float(np.degrees(neighbour_angle(out)))


def stand_far_apart(cameras: Sequence[Camera]) -> bool:
    """Return whether cameras stand around a subject so far apart that each alone sees its side of it."""
    return _FEWEST <= len(cameras) <= _MOST and np.degrees(FAR_APART) < angle_to_next(cameras) < np.inf


def need_hulls(cameras: Sequence[Camera], iterations: int) -> bool:
    """Return whether trainings of so many iterations place movers by hulls and the room by a backdrop.

    Up to 55 degrees apart, a long training finds places in the pictures, and the room is 1 dB better (docs/tried.md).
    """
    return stand_far_apart(cameras) and (iterations < LONG or angle_to_next(cameras) > _NEAR_ENOUGH)


def vertical_of(cameras: Sequence[Camera]) -> Doubles:
    """Return the way up [3] of cameras that do not lie on their sides: their horizontal axes are at right angles to it.

    The result is that of two or more cameras that look in different directions.
    """
    turns = np.array([camera.world_to_camera[:3, :3] for camera in cameras])
    up = np.asarray(np.linalg.svd(turns[:, 0])[2][2])
    return up if up @ turns[:, 1].sum(0) < 0 else -up


def level(offsets: Doubles, up: Doubles) -> Doubles:
    """Return the horizontal parts of offsets [P, 3]; `up` is of length one."""
    return np.asarray(offsets - (offsets @ up)[:, None] * up)
