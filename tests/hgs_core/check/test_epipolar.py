"""Distances from epipolar lines, against points with known projections."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.epipolar import FAR, Pair, Rig, camera_errors, pair_errors, sampson_distances, signed_distances
from hgs_core.points.features import fundamental_matrix
from tests.rigs import dome, matches_of


def test_the_fundamental_matrix_is_that_of_the_cameras() -> None:
    cameras = dome()
    np.testing.assert_allclose(
        Rig.of(cameras).fundamental(1, 5), fundamental_matrix(cameras[1], cameras[5]), atol=1e-12
    )


def test_true_matches_lie_on_their_lines_and_moved_ones_as_far_away_as_they_were_moved() -> None:
    cameras = dome(2)
    rig, pair = Rig.of(cameras), matches_of(cameras, noise=0, chance=0)[0, 1]
    assert sampson_distances(rig, 0, 1, pair).max() < 1e-9
    line = np.column_stack((pair.first, np.ones(60))) @ rig.fundamental(0, 1).T
    across = line[:, :2] / np.linalg.norm(line[:, :2], axis=1, keepdims=True)
    moved = signed_distances(rig.fundamental(0, 1), pair.first, pair.second + 2 * across)
    # The Sampson distance shares a shift of one picture between both.
    assert np.all((moved > 0.8) & (moved < 2.2))
    back = signed_distances(rig.fundamental(0, 1), pair.first, pair.second - 2 * across)
    np.testing.assert_allclose(back, -moved, rtol=0.05)


def test_two_cameras_at_one_place_have_no_lines() -> None:
    camera = dome(1)[0]
    rig = Rig.of([camera, camera])
    pair = Pair(np.array([[10.0, 20.0]]), np.array([[30.0, 40.0]]), 1.0)
    assert sampson_distances(rig, 0, 1, pair).tolist() == [FAR]


def test_a_camera_without_matches_has_no_error() -> None:
    cameras = dome(3)
    pairs = {(0, 1): matches_of(cameras)[0, 1]}
    errors = camera_errors(3, pair_errors(Rig.of(cameras), pairs), pairs)
    assert errors[2] is None
    assert errors[0] == errors[1] == pytest.approx(0.15, abs=0.1)
