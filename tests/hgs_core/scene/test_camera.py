"""Numbers that are not a camera are refused."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.scene.camera import Camera, looking_at, neighbour_angle


@pytest.mark.parametrize(
    ("rotation", "complaint"),
    [
        (1.01 * np.eye(3), "not orthonormal"),
        (1e300 * np.ones((3, 3)), "not orthonormal"),  # products overflow
        (np.diag([1.0, 1.0, -1.0]), "reflection"),
        (np.full((3, 3), np.nan), "not a finite 4x4 matrix"),
    ],
)
def test_poses_that_do_not_rotate_are_refused(rotation: np.ndarray, complaint: str) -> None:
    pose = np.eye(4)
    pose[:3, :3] = rotation
    with pytest.raises(InputError, match=complaint):
        Camera("c", 64, 48, 50.0, 50.0, 32.0, 24.0, pose)


@pytest.mark.parametrize("name", ["width", "height"])
def test_a_size_that_is_no_number_is_refused(name: str) -> None:
    value = Camera("cam00", 64, 48, 50.0, 50.0, 32.0, 24.0, np.eye(4)).to_json()
    with pytest.raises(InputError, match="camera: unreadable"):
        Camera.from_json({**value, name: float("inf")})


def test_a_camera_looks_at_a_point_with_the_worlds_y_down_and_nothing_mirrored() -> None:
    pose = looking_at((1.0, -2.0, -5.0), (1.0, -2.0, 3.0))
    camera = Camera("", 200, 100, 50.0, 50.0, 100.0, 50.0, pose)
    pixels, depth = camera.project(np.array([[1.0, -2.0, 3.0], [2.0, -2.0, 3.0], [1.0, -1.0, 3.0]]))
    np.testing.assert_allclose(pixels, [[100, 50], [106.25, 50], [100, 56.25]])  # x to the right, y down
    np.testing.assert_allclose(depth, 8.0)
    np.testing.assert_allclose(camera.position, (1.0, -2.0, -5.0))
    turned = looking_at((1.0, -2.0, -5.0), (1.0, -2.0, 3.0), roll=np.pi / 2)
    np.testing.assert_allclose(turned[:2, :3], [[0, 1, 0], [-1, 0, 0]], atol=1e-15)


@pytest.mark.parametrize(
    ("size", "expected"), [((1000, 700), (1000, 700)), ((1001, 700), (500, 350)), ((800, 3000), (267, 1000))]
)
def test_a_picture_is_reduced_by_the_least_whole_factor(size: tuple[int, int], expected: tuple[int, int]) -> None:
    within = Camera("c", *size, 50.0, 50.0, 32.0, 24.0, np.eye(4)).within(1000)
    assert (within.width, within.height) == expected


@pytest.mark.parametrize(
    ("pixel", "depth", "shown", "with_a_tenth_beside"),
    [
        ((0.0, 0.0), 1.0, True, True),
        ((99.9, 49.9), 1.0, True, True),
        ((100.0, 20.0), 1.0, False, True),
        ((-10.0, -5.0), 1.0, False, True),
        ((-10.1, 20.0), 1.0, False, False),
        ((50.0, 55.0), 1.0, False, False),
        ((50.0, 20.0), 0.5, False, False),  # the near plane
        ((np.nan, 20.0), 1.0, False, False),
    ],
)
def test_a_point_is_shown_within_the_sides_and_beyond_the_near_plane(
    pixel: tuple[float, float], depth: float, shown: bool, with_a_tenth_beside: bool
) -> None:
    camera = Camera("a", 100, 50, 80.0, 80.0, 50.0, 25.0, np.eye(4), near=0.5)
    pixels, depths = np.array([pixel]), np.array([depth])
    assert camera.shows(pixels, depths) == shown
    assert camera.shows(pixels, depths, beside=0.1) == with_a_tenth_beside


def test_another_depth_may_take_the_place_of_the_near_plane() -> None:
    camera = Camera("a", 100, 50, 80.0, 80.0, 50.0, 25.0, np.eye(4), near=0.5)
    pixels, depths = np.full((3, 2), 10.0), np.array([0.0, 0.4, 0.6])
    assert camera.shows(pixels, depths).tolist() == [False, False, True]
    assert camera.shows(pixels, depths, beyond=0).tolist() == [False, True, True]


def test_the_angle_between_neighbours_is_the_median_of_those_to_the_nearest_other() -> None:
    angles = np.deg2rad([0.0, 10.0, 50.0])
    directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(3)], 1)
    assert neighbour_angle(directions) == pytest.approx(np.deg2rad(10))
    assert neighbour_angle(directions[:1]) == 0.0
