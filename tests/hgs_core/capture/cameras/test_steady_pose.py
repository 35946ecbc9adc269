"""Poses that were solved picture by picture become one."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.capture.cameras.steady_pose import median_pose, pose_groups, rig_radius, same_pose, spread
from tests.hgs_core.capture import layouts

Pose = npt.NDArray[np.float64]


def jittered(pose: Pose, chance: np.random.Generator, turn: float = 1e-4, move: float = 2e-4) -> Pose:
    a = chance.normal(0, turn, 3)
    left, _, right = np.linalg.svd(
        (np.eye(3) + np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])) @ pose[:3, :3]
    )
    found = np.eye(4)
    found[:3, :3] = left @ right
    found[:3, 3] = -found[:3, :3] @ (-pose[:3, :3].T @ pose[:3, 3] + chance.normal(0, move, 3))
    return found


def test_groups_are_the_cameras_and_medians_are_near_the_truth() -> None:
    chance = np.random.default_rng(0)
    truth = [camera.world_to_camera for camera in layouts.truth()]
    poses = [jittered(pose, chance) for _ in range(9) for pose in truth]
    radius = rig_radius(poses)
    groups = pose_groups(poses, radius)
    assert groups == [[camera + 4 * frame for frame in range(9)] for camera in range(4)]
    for group, pose in zip(groups, truth, strict=True):
        found = median_pose([poses[index] for index in group])
        np.testing.assert_allclose(found, pose, atol=4e-4)
        np.testing.assert_allclose(found[:3, :3] @ found[:3, :3].T, np.eye(3), atol=1e-12)
    assert spread([[poses[index] for index in group] for group in groups], radius).startswith("up to 0.0")


def test_an_outlier_moves_the_median_little() -> None:
    chance = np.random.default_rng(1)
    pose = layouts.truth()[0].world_to_camera
    poses = [jittered(pose, chance, 1e-5, 1e-5) for _ in range(8)] + [jittered(pose, chance, 1e-3, 1e-3)]
    np.testing.assert_allclose(median_pose(poses), pose, atol=5e-5)


def test_equal_poses_are_returned_as_they_are_and_nothing_is_said() -> None:
    pose = layouts.truth()[1].world_to_camera
    assert median_pose([pose, pose.copy()]) is pose
    assert spread([[pose, pose], [pose]], 1.0) == ""


@pytest.mark.parametrize(
    ("turn", "move", "same"), [(0.0, 0.0, True), (1e-3, 0.0, True), (5e-3, 0.0, False), (0.0, 0.01, False)]
)
def test_only_near_poses_are_the_same(turn: float, move: float, same: bool) -> None:
    other = np.eye(4)
    other[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    other[0, 3] = move
    assert same_pose(np.eye(4), other, 1.0) is same
