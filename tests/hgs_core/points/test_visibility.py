"""Worked out by hand: a camera at the origin that looks along z, and cameras of which it is plain which are alike."""

from __future__ import annotations

import numpy as np

from hgs_core.points.visibility import nearest_cameras, pixels_inside
from hgs_core.scene.camera import Camera, looking_at

CAMERA = Camera("", 10, 6, 10.0, 10.0, 5.0, 3.0, np.eye(4))


def test_points_within_the_picture_and_before_the_camera_have_the_pixel_they_hit() -> None:
    points = np.array(
        [
            [0, 0, 1],  # column 5, row 3
            [0, 0, -1],  # behind
            [-0.5, -0.3, 1],  # the upper left corner
            [0.49, 0.29, 1],  # last pixel
            [0.5, 0, 1],  # right of the last column
            [0, 0.3, 1],  # below the last row
            [-0.51, 0, 1],  # left of the first
            [0, -0.31, 1],  # above the first
            [0.98, 0.58, 2],  # the last pixel's ray, farther away
        ],
        float,
    )
    rows, pixels = pixels_inside(CAMERA, points)
    assert rows.tolist() == [0, 2, 3, 8]
    assert pixels.tolist() == [[5, 3], [0, 0], [9, 5], [9, 5]]


def test_points_nearer_than_asked_are_left_out() -> None:
    depths = np.array([[0, 0, z] for z in (0.1, 0.2, 0.3)])
    assert pixels_inside(CAMERA, depths, near=0.2)[0].tolist() == [2]


def camera(x: float, target: tuple[float, float, float]) -> Camera:
    return Camera("", 10, 6, 10.0, 10.0, 5.0, 3.0, looking_at((x, 0.0, 0.0), target))


def test_cameras_in_a_row_are_most_like_their_neighbours() -> None:
    cameras = [camera(x, (x, 0.0, 9.0)) for x in (0.0, 1.0, 3.0, 7.0)]
    assert nearest_cameras(cameras, 2) == [[1, 2], [0, 2], [1, 0], [2, 1]]


def test_of_cameras_at_one_place_those_that_look_alike_are_nearest() -> None:
    cameras = [camera(0.0, target) for target in ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.5, 0.0, 1.0))]
    assert nearest_cameras(cameras, 5) == [[2, 1], [2, 0], [0, 1]]


def test_a_camera_alone_has_no_neighbours() -> None:
    assert nearest_cameras([CAMERA], 3) == [[]]
