"""A wall filmed from the front: how much of it two cameras saw is the work of a ruler."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hgs_core.fit.seen_share import SeenShare
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera, looking_at

SPACING = 0.1


def wall(width: float = 4.0, height: float = 2.0, depth: float = 0.0) -> np.ndarray:
    """Points [P, 3] of a wall across the z axis, which cameras look along."""
    x, y = np.meshgrid(np.arange(-width, width, SPACING), np.arange(-height, height, SPACING))
    return np.stack([x.ravel(), y.ravel(), np.full(x.size, depth)], 1)


def scene_of(points: np.ndarray, grey: float = 0.5) -> HybridScene:
    count = len(points)
    quats = np.tile(np.array([1, 0, 0, 0], np.float32), (count, 1))
    scales = np.tile(np.log(np.array([0.07, 0.07, 0.01], np.float32)), (count, 1))
    splats = StaticSplats(
        points.astype(np.float32), scales, quats, np.full(count, 6, np.float32), np.full((count, 3), grey, np.float32)
    )
    return HybridScene(splats, (Segment(0.0, 1.0, DynamicSplats.empty()),))


def camera(x: float, z: float, to: float = 0.0, y: float = 0.0) -> Camera:
    """A camera that sees 1 unit to each side, and 0.75 up and down, in a distance of 1, level where `y` is 0."""
    return Camera("", 64, 48, 32.0, 32.0, 32.0, 24.0, looking_at([x, y, z], [to, 0.0, 0.0]), near=0.05)


RIG = [camera(-0.1, -2), camera(0.1, -2)]


def test_where_the_cameras_stand_nearly_all_is_seen() -> None:
    share = SeenShare(scene_of(wall()), RIG)
    assert share.filled == 1
    assert share.of(camera(0.0, -2)) > 0.9


def test_what_one_camera_saw_is_not_seen() -> None:
    share = SeenShare(scene_of(wall()), [camera(-1.0, -2, to=-1.0), camera(1.0, -2, to=1.0)])
    assert share.of(camera(0.0, -2)) == pytest.approx(0.5, abs=0.06)  # their pictures meet in the middle two units


def test_a_second_view_is_one_from_a_small_angle() -> None:
    share = SeenShare(scene_of(wall()), [camera(-1.0, -2, to=-1.0), camera(1.0, -2, to=1.0)])
    assert share.twice(math.radians(60)) == pytest.approx(0.5, abs=0.06)  # the angle is 45 to 53 degrees
    assert share.twice(math.radians(40)) < 0.02
    assert SeenShare(scene_of(wall()), RIG).twice(math.radians(40)) > 0.85


def test_where_nothing_stands_still_nothing_lacks_a_second_view() -> None:
    assert SeenShare(scene_of(wall(0, 0)), RIG).twice(1.0) == 1


def test_a_single_camera_is_its_own_witness() -> None:
    assert SeenShare(scene_of(wall()), RIG[:1]).of(RIG[0]) > 0.9


def test_from_farther_away_the_rims_are_not_seen() -> None:
    share = SeenShare(scene_of(wall(8, 6)), RIG)
    assert share.of(camera(0.0, -4)) == pytest.approx(1.9 * 1.5 / (4 * 3), abs=0.03)


def test_nothing_is_seen_from_behind_nor_from_much_nearer() -> None:
    share = SeenShare(scene_of(wall()), RIG)
    assert share.of(camera(0.0, 2)) < 0.05
    assert share.of(camera(0.0, -0.6)) < 0.05


def test_what_is_hidden_from_the_cameras_is_not_seen() -> None:
    board = wall(0.4, 1.0, depth=-1.2)  # hides a strip of the wall, 2 units wide
    behind_it = camera(0.0, -1.15)  # 2.3 units wide is what it sees of the wall
    assert SeenShare(scene_of(wall()), RIG).of(behind_it) > 0.9
    assert SeenShare(scene_of(np.concatenate([wall(), board])), RIG).of(behind_it) < 0.3


def test_an_empty_place_counts_where_the_cameras_saw_it_so() -> None:
    half = wall()
    share = SeenShare(scene_of(half[half[:, 0] < 0.5]), RIG)
    # The eye looks at -1 to 3 in the plane of the wall, which ends at 0.5; the cameras' pictures end at 2.
    assert share.of(camera(1, -2, to=1)) == pytest.approx(3 / 4, abs=0.06)


def test_where_nothing_is_drawn_nothing_is_seen() -> None:
    assert SeenShare(scene_of(wall(1, 1)), RIG).of(camera(50.0, -2, to=50)) == 0


def test_pictures_that_are_mostly_empty_are_told() -> None:
    assert SeenShare(scene_of(wall(1, 1)), RIG).filled == pytest.approx(2.2**2 / (4 * 3), abs=0.03)
