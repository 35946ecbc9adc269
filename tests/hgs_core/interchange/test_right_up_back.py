from __future__ import annotations

import numpy as np

from hgs_core.interchange.right_up_back import other_way_up, our_rotations, stored_rotations
from hgs_core.scene.rotations import matrices, unit_quaternions

QUATS = unit_quaternions(np.random.default_rng(0).normal(size=(20, 4)))


def test_down_becomes_up_and_forward_becomes_back_by_half_a_turn() -> None:
    assert other_way_up(np.array([[1.0, 2.0, 3.0]])).tolist() == [[1, -2, -3]]
    turn = other_way_up(np.eye(3))
    assert np.linalg.det(turn) == 1  # no mirror


def test_a_rotation_turns_along_with_the_places() -> None:
    """A place turned and then stored is the stored place turned by the stored rotation."""
    places = np.random.default_rng(1).normal(size=(20, 3, 1))
    stored = matrices(stored_rotations(QUATS)[:, [3, 0, 1, 2]])
    np.testing.assert_allclose(
        stored @ other_way_up(places[..., 0])[..., None],
        other_way_up((matrices(QUATS) @ places)[..., 0])[..., None],
        atol=1e-12,
    )


def test_rotations_come_back() -> None:
    np.testing.assert_array_equal(our_rotations(stored_rotations(QUATS)), QUATS)
