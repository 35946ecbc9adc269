"""Directions that surfaces face, from the points that lie on them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.points.neighbours import nearest_neighbours

__all__ = ["surface_normals"]

_NEIGHBOURS = 60  # fewer say more of the error of depths than of the surface
_FLAT = 0.25  # variance across a surface in shares of that along its narrower side, at most
_LINE = 0.01  # variance along the narrower side in shares of that along the wider: less is a line


def surface_normals(xyz: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.float32]:
    """Return a unit normal [P, 3] for each point [P, 3], of either sign; zero where its neighbours lie on no surface.

    The normal is the direction in which the nearest 60 points vary least (Hoppe et al., SIGGRAPH 1992). They lie on a
    surface if they vary at most half as far that way as along it, and do not lie on a line.
    """
    count = min(_NEIGHBOURS, len(xyz) - 1)
    if count < 3:
        return np.zeros((len(xyz), 3), np.float32)
    points = np.asarray(xyz, np.float64)
    around = points[nearest_neighbours(points, count)]  # [P, count, 3]
    around -= around.mean(axis=1, keepdims=True)
    variances, directions = np.linalg.eigh(around.transpose(0, 2, 1) @ around)
    flat = (variances[:, 0] <= _FLAT * variances[:, 1]) & (variances[:, 1] > _LINE * variances[:, 2])
    return np.where(flat[:, None], directions[:, :, 0], 0.0).astype(np.float32)
