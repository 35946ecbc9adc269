"""Rigs that surround a subject with few cameras, told from all others."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.far_apart import angle_to_next, need_hulls, stand_far_apart, vertical_of
from hgs_core.scene.camera import Camera, looking_at
from tests.walking_body import CAMERAS


def ring(count: int, arc: float = 360.0, height: float = 1.0) -> list[Camera]:
    cameras = []
    for angle in np.deg2rad(np.arange(count) * arc / count):
        place = np.array((3 * np.sin(angle), -height, 3 * np.cos(angle)))
        cameras.append(Camera("c", 64, 48, 60, 60, 32, 24, looking_at(place, np.zeros(3))))
    return cameras


@pytest.mark.parametrize("count", [3, 4, 6])
def test_few_cameras_all_around_stand_far_apart(count: int) -> None:
    assert stand_far_apart(ring(count))
    level = ring(count, height=0.0)
    np.testing.assert_allclose(angle_to_next(level), 360 / count, atol=1e-6)


@pytest.mark.parametrize(
    ("count", "iterations", "needed"), [(4, 20_000, True), (7, 3_200, True), (7, 20_000, False), (16, 3_200, False)]
)
def test_long_trainings_of_cameras_at_a_middle_distance_need_no_hulls(
    count: int, iterations: int, needed: bool
) -> None:
    assert need_hulls(ring(count), iterations) is needed


def test_one_far_camera_among_near_ones_changes_nothing() -> None:
    assert not stand_far_apart([*ring(16)[:6], ring(4)[2]])


@pytest.mark.parametrize("cameras", [ring(2), ring(16), ring(5, arc=60.0), ring(1), []])
def test_two_cameras_dense_rings_and_short_arcs_do_not(cameras: list[Camera]) -> None:
    assert not stand_far_apart(cameras)


def test_cameras_that_look_outwards_do_not() -> None:
    out = [Camera("c", 64, 48, 60, 60, 32, 24, looking_at(c.position, 2 * c.position)) for c in ring(4, height=0.0)]
    assert not stand_far_apart(out)
    assert angle_to_next(out) == float("inf")


def test_the_way_up_is_that_of_tilted_cameras_in_a_tilted_world() -> None:
    up = np.array((0.3, -0.9, 0.1)) / np.linalg.norm((0.3, -0.9, 0.1))
    places = [np.array(place) for place in ((3.0, -1.0, 0.2), (-1.0, -2.0, 2.5), (-2.0, 0.5, -2.0))]
    cameras = [Camera("c", 64, 48, 60, 60, 32, 24, looking_at(place, np.zeros(3), up=up)) for place in places]
    np.testing.assert_allclose(vertical_of(cameras), up, atol=1e-9)
    np.testing.assert_allclose(vertical_of(CAMERAS), (0, -1, 0), atol=1e-9)
