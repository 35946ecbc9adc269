"""Each mistake is made with a known rig, and must be told by its name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from hgs_core.check.causes import cause_of_camera, cause_of_rig, swapped_cameras
from hgs_core.check.epipolar import Pair, Rig
from tests.rigs import rig_and_matches

NAMES = [f"cam{i:02d}" for i in range(8)]
GOOD = (0, 1, 2, 4, 5, 6, 7)


def turned(rig: Rig, rows: list[list[float]]) -> Rig:
    axes = np.eye(4)
    axes[:3, :3] = rows
    return Rig(rig.intrinsics, axes @ rig.poses)


RIG_MISTAKES: dict[str, Callable[[Rig], Rig]] = {
    "the poses are inverted": lambda rig: Rig(rig.intrinsics, np.linalg.inv(rig.poses)),
    "OpenGL's axes for OpenCV's": lambda rig: turned(rig, [[1, 0, 0], [0, -1, 0], [0, 0, -1]]),
    "OpenCV's columns in poses_bounds": lambda rig: turned(rig, [[0, 1, 0], [1, 0, 0], [0, 0, -1]]),
    "OpenGL's columns in poses_bounds": lambda rig: turned(rig, [[0, -1, 0], [1, 0, 0], [0, 0, 1]]),
    "0.50 times it fits": lambda rig: rig.with_focal(2.0),
    "1.50 times it fits": lambda rig: rig.with_focal(1 / 1.5),
}


@pytest.mark.parametrize("mistake", RIG_MISTAKES)
def test_a_mistake_made_with_all_cameras_is_named(mistake: str) -> None:
    rig, pairs = rig_and_matches()
    cause = cause_of_rig(RIG_MISTAKES[mistake](rig), pairs, NAMES)
    assert cause is not None
    assert mistake in cause.problem
    assert cause.error < 0.5


def test_poses_in_the_order_of_names_as_text_are_named() -> None:
    rig, pairs = rig_and_matches(12)
    names = [str(i) for i in range(12)]
    order = sorted(range(12), key=lambda i: names[i])  # row r has the pose of camera order[r]
    cause = cause_of_rig(rig.rearranged(order), pairs, names)
    assert cause is not None
    assert "10 comes before 2" in cause.problem


def test_fisheye_pictures_are_named() -> None:
    rig, pairs = rig_and_matches()

    def seen(pixels: np.ndarray) -> np.ndarray:
        local = (pixels - (320, 240)) / 600
        r = np.linalg.norm(local, axis=1, keepdims=True)
        return np.asarray(local * (np.arctan(r) / r) * 600 + (320, 240))

    bent = {pair: Pair(seen(one.first), seen(one.second), one.weight) for pair, one in pairs.items()}
    cause = cause_of_rig(rig, bent, NAMES)
    assert cause is not None
    assert "fisheye" in cause.problem


def test_what_no_mistake_explains_is_not_explained() -> None:
    rig, pairs = rig_and_matches()
    numbers = np.random.default_rng(0)
    poses = rig.poses.copy()
    poses[:, :3, :3] = [np.linalg.qr(numbers.normal(size=(3, 3)))[0] for _ in range(8)]
    assert cause_of_rig(Rig(rig.intrinsics, poses), pairs, NAMES) is None


def with_pose(rig: Rig, change: Callable[[np.ndarray], np.ndarray]) -> Rig:
    return rig.with_pose(3, change(rig.poses[3]))


def in_centimetres(pose: np.ndarray) -> np.ndarray:
    changed = pose.copy()
    changed[:3, 3] *= 100
    return changed


CAMERA_MISTAKES: dict[str, Callable[[Rig], Rig]] = {
    "180 degrees, upside down": lambda rig: with_pose(rig, lambda pose: np.diag([-1.0, -1, 1, 1]) @ pose),
    "turned by 90 degrees": lambda rig: with_pose(
        rig, lambda pose: np.array([[0, 1.0, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) @ pose
    ),
    "OpenGL's axes": lambda rig: with_pose(rig, lambda pose: np.diag([1.0, -1, -1, 1]) @ pose),
    "its pose is inverted": lambda rig: with_pose(rig, np.linalg.inv),
    "0.50 times it fits": lambda rig: rig.with_focal(2.0, 3),
    "centimetres": lambda rig: with_pose(rig, in_centimetres),
}


@pytest.mark.parametrize("mistake", CAMERA_MISTAKES)
def test_a_mistake_made_with_one_camera_is_named(mistake: str) -> None:
    rig, pairs = rig_and_matches()
    cause = cause_of_camera(CAMERA_MISTAKES[mistake](rig), pairs, 3, GOOD)
    assert cause is not None
    assert mistake in cause.problem


def test_a_camera_that_was_knocked_is_told_by_how_much() -> None:
    rig, pairs = rig_and_matches()
    angle = np.radians(1.5)
    turn = np.eye(4)
    turn[:3, :3] = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    cause = cause_of_camera(with_pose(rig, lambda pose: turn @ pose), pairs, 3, GOOD)
    assert cause is not None
    assert "turned by 1.5 degrees" in cause.problem


def test_swapped_cameras_are_found_and_no_others() -> None:
    rig, pairs = rig_and_matches()
    order = [0, 1, 2, 6, 4, 5, 3, 7]
    assert swapped_cameras(rig.rearranged(order), pairs, (3, 6), (0, 1, 2, 4, 5, 7)) == [(3, 6)]
    spoilt = rig.with_focal(2.0, 3).with_focal(0.5, 6)
    assert swapped_cameras(spoilt, pairs, (3, 6), (0, 1, 2, 4, 5, 7)) == []
