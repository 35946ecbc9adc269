"""Which points fall inside which pictures, and which cameras see alike."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.scene.camera import Camera

__all__ = ["nearest_cameras", "pixels_inside"]


def pixels_inside(
    camera: Camera,
    xyz: npt.NDArray[np.floating[Any]],  # [P, 3]
    near: float = 1e-3,  # world units
) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Return the rows [K] of the points that project into the picture, and the pixels [K, 2] (column, row) they hit."""
    pixels, depths = camera.project(xyz)
    rows = np.flatnonzero(camera.shows(pixels, depths, beyond=near))
    return rows, pixels[rows].astype(np.int64)


def nearest_cameras(cameras: Sequence[Camera], count: int) -> list[list[int]]:
    """Return for each camera the `count` others most like it in view direction and place, the most alike first."""
    directions = np.array([camera.world_to_camera[2, :3] for camera in cameras])
    positions = np.array([camera.position for camera in cameras])
    extent = float(np.linalg.norm(positions - positions.mean(axis=0), axis=1).max()) or 1.0
    gaps = np.linalg.norm(positions[:, None] - positions, axis=2) / extent
    unlike = np.arccos(np.clip(directions @ directions.T, -1.0, 1.0)) + gaps
    np.fill_diagonal(unlike, np.inf)
    order = np.argsort(unlike, axis=1, kind="stable")[:, : min(count, len(cameras) - 1)]
    return [[int(index) for index in row] for row in order]
