from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.codec.encoder.viewpoint import find_viewpoint
from hgs_core.scene.camera import Camera

NO_POINTS = np.zeros((0, 3))


def test_a_ring_of_cameras_looks_at_its_middle(cameras: list[Camera]) -> None:
    view = find_viewpoint(cameras, NO_POINTS)
    np.testing.assert_allclose(view.center, [0, 0, 0], atol=0.05)
    assert view.extent == pytest.approx(np.hypot(4, 1.4), rel=0.02)
    np.testing.assert_allclose(view.up, [0, -1, 0], atol=1e-9)
    assert view.pixel == pytest.approx(view.extent / 500)


def test_along_parallel_axes_the_depth_of_the_points_decides(cameras: list[Camera]) -> None:
    poses = [np.eye(4) for _ in range(3)]
    for i, pose in enumerate(poses):
        pose[0, 3] = -0.1 * (i - 1)
    parallel = [dataclasses.replace(cameras[0], world_to_camera=pose) for pose in poses]
    points = np.random.default_rng(0).normal((0, 0, 5), 0.3, (200, 3))
    view = find_viewpoint(parallel, points)
    np.testing.assert_allclose(view.center, [0, 0, 5], atol=0.1)


def test_a_camera_alone_without_points_still_has_a_centre_before_it(cameras: list[Camera]) -> None:
    view = find_viewpoint(cameras[:1], NO_POINTS)
    assert cameras[0].project(np.array([view.center]))[1][0] > 0
    assert view.extent > 0
