"""Depths of triangles in a picture."""

from __future__ import annotations

import numpy as np

from hgs_core.points.mesh_depth import mesh_depth
from hgs_core.scene.camera import Camera, looking_at

CAMERA = Camera("a", 64, 48, 60.0, 60.0, 32.0, 24.0, np.eye(4))
FLOOR = np.array([[-50, 1, -50], [50, 1, -50], [50, 1, 50], [-50, 1, 50]], np.float64)[[[0, 1, 2], [0, 2, 3]]]


def wall(depth: float, half: float) -> np.ndarray:
    corners = np.array([[-half, -half, depth], [half, -half, depth], [half, half, depth], [-half, half, depth]])
    return corners[[[0, 1, 2], [2, 3, 0]]]


def test_a_floor_that_passes_below_the_camera_is_cut_off_behind_it() -> None:
    depths = mesh_depth(FLOOR, CAMERA)
    rows = np.arange(48) + 0.5
    right = np.where(rows > 24, 60 / np.maximum(rows - 24, 1e-9), 0)
    right[right > 50] = 0
    np.testing.assert_allclose(depths, np.repeat(right[:, None], 64, 1), rtol=1e-5)


def test_the_nearest_of_several_surfaces_counts_whatever_their_order() -> None:
    near, far = wall(2.0, 0.5), wall(4.0, 50.0)
    depths = mesh_depth(np.concatenate([near, far]), CAMERA)
    np.testing.assert_array_equal(depths, mesh_depth(np.concatenate([far, near[:, ::-1]]), CAMERA))
    assert np.unique(depths).tolist() == [2.0, 4.0]
    assert (depths == 2.0).sum() == 30 * 30


def test_a_wall_that_closes_the_hole_before_a_camera_is_cut_off() -> None:
    room = np.concatenate([wall(0.05, 1.0), wall(4.0, 50.0)])
    assert np.unique(mesh_depth(room, CAMERA)).tolist() == [np.float32(0.05)]
    assert np.unique(mesh_depth(room, CAMERA, 1.0)).tolist() == [4.0]


def test_what_is_beside_or_behind_the_camera_is_not_seen() -> None:
    assert not mesh_depth(wall(-2.0, 50.0), CAMERA).any()
    assert not mesh_depth(wall(2.0, 0.5) + np.array([9.0, 0, 0]), CAMERA).any()


def test_depths_are_those_of_project_in_a_turned_camera() -> None:
    """Triangles smaller than a pixel, larger ones, and needles."""
    random = np.random.default_rng(3)
    pose = looking_at(np.array([1.0, -2.0, -4.0]), np.zeros(3), roll=0.3)
    camera = Camera("b", 40, 30, 35.0, 36.0, 19.0, 16.0, pose)
    middles = random.uniform(-1, 1, (400, 1, 3))
    corners = middles + random.normal(size=(400, 3, 3)) * 10 ** random.uniform(-3, 0, (400, 1, 1))
    depths = mesh_depth(corners, camera)
    row, column = np.mgrid[0:30, 0:40] + 0.5
    rays = camera.rays(np.stack([column.ravel(), row.ravel()], 1))
    nearest = np.full(len(rays), np.inf)
    for a, b, c in corners:  # Moller and Trumbore
        p = np.cross(rays, c - a)
        size = p @ (b - a)
        u = (p @ (camera.position - a)) / size
        q = np.cross(camera.position - a, b - a)
        v, depth = (rays @ q) / size, (q @ (c - a)) / size
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (depth > 1e-3)
        nearest = np.where(hit, np.minimum(nearest, depth), nearest)
    right = np.where(np.isinf(nearest), 0, nearest).reshape(30, 40)
    assert (np.abs(depths - right) <= 1e-4 * right).mean() > 0.999
