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


def test_a_plane_goes_on_beyond_what_is_known_of_it() -> None:
    known = (COLUMN < 30) & (ROW >= 20)
    np.testing.assert_allclose(completed(np.where(known, PLANE, 9.0), known), PLANE, rtol=0.005)


def test_noise_of_what_is_known_does_not_tilt_what_goes_on() -> None:
    known = COLUMN < 30
    noise = np.random.default_rng(0).normal(0, 0.01, PLANE.shape)
    np.testing.assert_allclose(completed(PLANE * (1 + noise), known)[~known], PLANE[~known], rtol=0.03)


def test_slopes_are_followed_to_half_and_to_twice_what_is_known() -> None:
    known = (COLUMN >= 25) & (COLUMN < 35)
    steep = 0.2 + 0.01 * (COLUMN - 30)
    filled = completed(steep, known)
    assert filled.min() == steep[known].min() / 2
    assert filled.max() == steep[known].max() * 2


def test_a_single_known_value_is_that_of_all() -> None:
    known = np.zeros(PLANE.shape, bool)
    known[3, 50] = True
    np.testing.assert_allclose(completed(PLANE, known), PLANE[3, 50], rtol=1e-6)


@pytest.mark.parametrize("shape", [(1, 1), (3, 40), (40, 3), (7, 11)])
def test_small_pictures_are_completed_too(shape: tuple[int, int]) -> None:
    known = np.zeros(shape, bool)
    known[0, 0] = True
    np.testing.assert_allclose(completed(np.full(shape, 0.5), known), 0.5, rtol=1e-6)


@pytest.mark.parametrize("share", [0, 1])
def test_all_or_nothing_known_is_left_as_it_is(share: int) -> None:
    known = np.full(PLANE.shape, bool(share))
    np.testing.assert_array_equal(completed(PLANE, known), PLANE * share)
