from __future__ import annotations

import numpy as np
import pytest

from hgs_core.capture.cameras.rigid_poses import MIRROR
from hgs_core.check.readings import readings, rotations
from tests.rigs import dome

POSES = np.array([camera.world_to_camera for camera in dome(3)])


@pytest.mark.parametrize("matrices", [POSES, POSES @ MIRROR])
def test_all_readings_are_rotations_and_no_two_are_one(matrices: np.ndarray) -> None:
    found = [reading.poses(matrices) for reading in readings(matrices)]
    assert len(found) == (95 if matrices is POSES else 96)
    assert np.allclose(np.linalg.det(found), 1)
    moves = np.array([poses[1:] @ np.linalg.inv(poses[0]) for poses in found]).reshape(len(found), -1)
    apart = np.abs(moves[:, None] - moves[None]).max(axis=2) + np.eye(len(found))
    assert apart.min() > 0.01


def test_turns_of_the_world_leave_a_rig_as_it_is_and_so_do_all_mirrors() -> None:
    for mirror in (MIRROR, np.diag((1.0, -1.0, 1.0, 1.0)), np.diag((1.0, 1.0, -1.0, 1.0))):
        stored = POSES @ mirror
        read = next(one for one in readings(stored) if np.array_equal(one.axes, np.eye(4)) and not one.inverse)
        assert read.mirrored
        found = read.poses(stored)
        np.testing.assert_allclose(found[1:] @ np.linalg.inv(found[0]), POSES[1:] @ np.linalg.inv(POSES[0]), atol=1e-9)


def test_what_a_reading_says() -> None:
    said = {reading.problem() for reading in readings(POSES)} | {
        reading.problem() for reading in readings(POSES @ MIRROR)
    }
    assert "the poses are inverted (world-to-camera for camera-to-world, or the reverse)" in said
    assert "the poses are of a left-handed world, of which x is turned" in said
    assert "the poses have translations of the wrong sign" in said
    assert len(said) == 191


def test_rotations_are_24_and_begin_with_none() -> None:
    found = rotations()
    assert len({axes.tobytes() for axes in found}) == 24
    assert np.array_equal(found[0], np.eye(4))
