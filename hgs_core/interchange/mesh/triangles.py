"""A surface of triangles."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.arrays import Doubles
from hgs_core.base.errors import InputError

__all__ = ["MOST_BYTES", "Mesh", "mesh_of_polygons"]

MOST_BYTES = 1 << 30
"""Bytes of the largest file that is read."""

_MOST_TRIANGLES = 5_000_000
_SIMPLER = "give a simpler one: a million triangles show a room"


@dataclass(frozen=True)
class Mesh:
    """A surface of triangles in the world of the cameras."""

    vertices: Doubles  # [V, 3] world units
    triangles: npt.NDArray[np.int64]  # [T, 3] rows of vertices

    @property
    def corners(self) -> Doubles:
        """The triangles' corners [T, 3, 3]."""
        return self.vertices[self.triangles]


def mesh_of_polygons(path: Path, vertices: Doubles, polygons: npt.NDArray[Any]) -> Mesh:
    """Return the mesh of polygons [P, K], rows of vertices [V, 3], ended by -1 where they have fewer than K corners.

    A polygon becomes a fan around its first corner. `path` is for messages.

    Raises:
        InputError: there is no triangle, there are too many, or a polygon names a vertex that there is not.
    """
    fans = [polygons[:, (0, k, k + 1)] for k in range(1, polygons.shape[1] - 1)] if polygons.ndim == 2 else []
    parts = [fan[fan[:, 2] != -1] for fan in fans]
    count = sum(len(part) for part in parts)
    if count == 0:
        raise InputError(path, "has no triangles", "give a surface, not points alone")
    if count > _MOST_TRIANGLES:
        raise InputError(path, f"has {count} triangles, and {_MOST_TRIANGLES} are the most that are read", _SIMPLER)
    triangles = np.concatenate(parts).astype(np.int64)
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        wrong = triangles.min() if triangles.min() < 0 else triangles.max()
        raise InputError(path, f"has a triangle of vertex {wrong}; there are {len(vertices)}", "export it again")
    finite = np.asarray(np.isfinite(vertices).all(1))
    if not finite[triangles].all():
        raise InputError(path, f"has vertex {int(np.argmin(finite))} in a place that is none", "export it again")
    return Mesh(vertices, triangles)
