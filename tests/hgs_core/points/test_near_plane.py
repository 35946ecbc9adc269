"""Near planes that follow the scene's depth."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.near_plane import with_near_planes
from tests.synthetic import ring_of_cameras


@pytest.mark.parametrize("scale", [0.01, 1.0, 1000.0])
def test_near_planes_are_a_share_of_the_nearest_depth_at_any_scale(scale: float) -> None:
    cameras = ring_of_cameras(3, 64, 48)
    for camera in cameras:
        camera.world_to_camera[:3, 3] *= scale
    points = (np.random.default_rng(0).uniform(-0.1, 0.1, (200, 3)) * scale).astype(np.float32)
    for camera in with_near_planes(cameras, points):
        assert camera.near == pytest.approx(0.6 * 2.9 * scale, rel=0.05)


def test_a_few_near_points_hardly_count() -> None:
    cameras = ring_of_cameras(3, 64, 48)
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (500, 3)).astype(np.float32)
    points[:2] = cameras[0].position * 0.95  # right before the first camera
    assert with_near_planes(cameras, points)[0].near == pytest.approx(0.6 * 2.9, rel=0.05)


def test_near_planes_are_never_nearer_than_a_share_of_the_median_depth() -> None:
    cameras = ring_of_cameras(3, 64, 48)
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (500, 3)).astype(np.float32)
    points[:50] = cameras[0].position * 0.99
    assert with_near_planes(cameras, points)[0].near == pytest.approx(0.08 * 3, rel=0.05)


def test_a_camera_that_sees_no_point_takes_the_others_plane() -> None:
    cameras = ring_of_cameras(3, 64, 48)
    cameras[1].world_to_camera[:3] *= [[-1], [1], [-1]]  # turned away
    points = np.random.default_rng(0).uniform(-0.1, 0.1, (50, 3)).astype(np.float32)
    planes = [camera.near for camera in with_near_planes(cameras, points)]
    assert planes[1] == pytest.approx((planes[0] + planes[2]) / 2)


def test_without_points_nothing_changes() -> None:
    cameras = ring_of_cameras(2, 64, 48)
    assert [c.near for c in with_near_planes(cameras, np.zeros((0, 3), np.float32))] == [0.01, 0.01]
