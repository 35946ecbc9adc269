"""Polygons as triangles, and polygons of vertices that there are not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.interchange.mesh.triangles import mesh_of_polygons

FILE = Path("room.ply")
VERTICES = np.arange(15.0).reshape(5, 3)


def test_a_polygon_becomes_a_fan_around_its_first_corner() -> None:
    mesh = mesh_of_polygons(FILE, VERTICES, np.array([[0, 1, 2, -1, -1], [4, 3, 2, 1, 0]]))
    assert sorted(map(tuple, mesh.triangles.tolist())) == [(0, 1, 2), (4, 1, 0), (4, 2, 1), (4, 3, 2)]
    np.testing.assert_array_equal(mesh.corners[0, 1], VERTICES[1])


@pytest.mark.parametrize(
    ("polygons", "problem"),
    [
        ([[0, 1, 5]], r"room\.ply: has a triangle of vertex 5; there are 5; export it again"),
        ([[0, -2, 1]], r"has a triangle of vertex -2"),
        ([[0, 1]], r"has no triangles"),
        ([[0, 1, -1]], r"has no triangles"),
    ],
)
def test_what_is_no_triangle_is_refused(polygons: list[list[int]], problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        mesh_of_polygons(FILE, VERTICES, np.array(polygons))


def test_a_vertex_that_is_nowhere_is_refused() -> None:
    vertices = VERTICES.copy()
    vertices[2, 1] = np.nan
    with pytest.raises(InputError, match=r"has vertex 2 in a place that is none"):
        mesh_of_polygons(FILE, vertices, np.array([[0, 1, 2]]))
