"""Completed depths: known ones stay, and a blank part of a plane becomes that plane."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.depth_completion import completed

ROW, COLUMN = np.mgrid[0:40, 0:60]
PLANE = 0.2 + 0.003 * ROW + 0.001 * COLUMN


def test_a_hole_in_a_plane_is_filled_with_the_plane() -> None:
    known = np.ones(PLANE.shape, bool)
    known[10:25, 20:40] = False
    np.testing.assert_allclose(completed(np.where(known, PLANE, 9.0), known), PLANE, rtol=0.005)


def test_known_values_stay() -> None:
    known = np.random.default_rng(0).random(PLANE.shape) < 0.2
    assert np.array_equal(completed(PLANE, known)[known], PLANE[known])


def test_unknown_values_lie_between_the_known_ones() -> None:
    known = np.zeros(PLANE.shape, bool)
    known[3, 3] = known[30, 50] = True
    filled = completed(PLANE, known)
    assert PLANE[3, 3] <= filled.min() <= filled.max() <= PLANE[30, 50]


@pytest.mark.parametrize("share", [0, 1])
def test_all_or_nothing_known_is_left_as_it_is(share: int) -> None:
    known = np.full(PLANE.shape, bool(share))
    np.testing.assert_array_equal(completed(PLANE, known), PLANE * share)
