from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.epipolar import Pair, Rig
from hgs_core.check.poses import judge_poses
from tests.rigs import rig_and_matches

NAMES = [f"cam{i:02d}" for i in range(8)]


def test_a_right_rig_has_no_finding() -> None:
    rig, pairs = rig_and_matches()
    assert judge_poses(rig, pairs, NAMES)[1] == []


def test_swapped_cameras_are_one_finding_that_stops_and_names_both() -> None:
    rig, pairs = rig_and_matches()
    (finding,) = judge_poses(rig.rearranged([0, 5, 2, 3, 4, 1, 6, 7]), pairs, NAMES)[1]
    assert finding.stops
    assert finding.cameras == ("cam01", "cam05")
    assert "swapped" in finding.problem


def test_a_camera_with_the_pose_of_another_is_named_with_it() -> None:
    rig, pairs = rig_and_matches()
    (finding,) = judge_poses(rig.with_pose(3, rig.poses[2]), pairs, NAMES)[1]
    assert finding.stops
    assert "cam02" in finding.sentence()
    assert "cam03" in finding.sentence()


def test_poses_without_rotations_are_told() -> None:
    rig, pairs = rig_and_matches()
    poses = np.tile(np.eye(4), (8, 1, 1))
    poses[:, :3, 3] = -rig.centres()
    (finding,) = judge_poses(Rig(rig.intrinsics, poses), pairs, NAMES)[1]
    assert finding.stops
    assert "same rotation" in finding.problem


def test_cameras_that_share_no_view_are_counted_and_do_not_stop() -> None:
    rig, pairs = rig_and_matches()
    few = {pair: one for pair, one in pairs.items() if set(pair) <= {0, 1, 2, 3, 4}}
    (finding,) = judge_poses(rig, few, NAMES)[1]
    assert not finding.stops
    assert finding.cameras == ("cam05", "cam06", "cam07")
    assert "3 of 8 cameras share no view" in finding.problem


@pytest.mark.parametrize("features", [0, 60, 700])
def test_cameras_none_of_which_shares_a_view_stop_if_their_pictures_would_tell(features: int) -> None:
    rig, _ = rig_and_matches()
    suspects, (finding,) = judge_poses(rig, {}, NAMES, [features] * 8)
    assert suspects.unjudged == tuple(range(8))
    assert finding.stops == (features == 700)
    assert "8 of 8 cameras share no view" in finding.problem


@pytest.mark.parametrize(("count", "partners", "told"), [(40, 1, False), (80, 1, True), (40, 2, True)])
def test_few_matches_with_one_camera_are_chance_where_no_mistake_explains_them(
    count: int, partners: int, told: bool
) -> None:
    """Camera 7 agrees with others about places where nothing is, by an epipolar geometry that no pose has."""
    rig, pairs = rig_and_matches()
    numbers = np.random.default_rng(1)
    others = [pair for pair in pairs if 7 in pair][:partners]
    kept = {pair: one for pair, one in pairs.items() if 7 not in pair}
    for pair in others:
        first, second = numbers.uniform(50, 400, (2, count, 2))
        kept[pair] = Pair(first, second, float(count))
    findings = judge_poses(rig, kept, NAMES)[1]
    assert [finding.cameras for finding in findings if finding.stops] == ([("cam07",)] if told else [])


def test_poor_poses_are_looked_at_and_do_not_stop() -> None:
    from tests.rigs import dome, matches_of

    cameras = dome()
    (finding,) = judge_poses(Rig.of(cameras), matches_of(cameras, noise=3.0, chance=0), NAMES)[1]
    assert not finding.stops
    assert "good poses stay below 1" in finding.problem


def test_a_rig_far_from_the_origin_is_told() -> None:
    rig, pairs = rig_and_matches()
    poses = rig.poses.copy()
    poses[:, :3, 3] -= poses[:, :3, :3] @ (1e6, 0.0, 0.0)
    (finding,) = judge_poses(Rig(rig.intrinsics, poses), pairs, NAMES)[1]
    assert "from the origin" in finding.problem
