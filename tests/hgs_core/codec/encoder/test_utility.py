from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.codec.encoder.utility import SetUtility, estimated_utility, grades, pixels_per_unit
from hgs_core.scene.camera import Camera, looking_at

CAMERA = Camera("", 100, 80, 200.0, 50.0, 50.0, 40.0, np.eye(4))  # a unit at depth 1 fills sqrt(200 * 50) = 100 pixels


def test_a_unit_fills_as_many_pixels_as_the_focal_length_over_the_depth() -> None:
    found = pixels_per_unit(np.array([[0, 0, 1.0], [0, 0, 4.0], [0.4, 0, 2.0]]), [CAMERA])
    np.testing.assert_allclose(found, [100, 25, 50])


def test_of_several_cameras_those_that_see_the_point_count_by_their_squares() -> None:
    nearer = dataclasses.replace(CAMERA, world_to_camera=looking_at((0, 0, 3.0), (0, 0, 4.0)))
    away = dataclasses.replace(CAMERA, world_to_camera=looking_at((0, 0, 3.9), (0, 0, 3.0)))
    found = pixels_per_unit(np.array([[0, 0, 4.0]]), [CAMERA, nearer, away])
    np.testing.assert_allclose(found, [np.sqrt((25**2 + 100**2) / 2)])


@pytest.mark.parametrize("point", [(0, 0, -2.0), (50.0, 0, 0.5), (0, 2.0, 0.0)])
def test_a_point_that_nobody_sees_has_what_it_would_fill_in_the_nearest_camera(point: tuple[float, ...]) -> None:
    farther = dataclasses.replace(CAMERA, world_to_camera=looking_at((0, 0, -1000.0), (0, 0, -1001.0)))
    found = pixels_per_unit(np.array([point]), [farther, CAMERA, farther])
    np.testing.assert_allclose(found, [100 / np.linalg.norm(point)])


@pytest.mark.parametrize(("sigmas", "scale"), [((3.0, 2.0, 0.1), 1.0), ((0.05, 0.5, 1.0), 4.0)])
def test_a_guess_is_the_sum_of_squared_alphas_seen_along_the_shortest_axis_half_hidden(
    sigmas: tuple[float, ...], scale: float
) -> None:
    """Reference: the sum over pixels, with the 0.3 square pixels that rendering adds to variances."""
    a, b = sorted(np.sqrt((np.array(sigmas) * scale) ** 2 + 0.3))[1:]
    y, x = np.mgrid[-60:61, -60:61]
    alpha = 0.8 * np.exp(-(x * x / a**2 + y * y / b**2) / 2)
    found = estimated_utility(np.log([sigmas]), np.array([0.8]), np.array([scale]), shown=0.25)
    np.testing.assert_allclose(found, [0.25 * ((0.5 * alpha) ** 2).sum()], rtol=1e-3)


def test_a_grade_is_a_factor_of_four_in_utility_and_limited() -> None:
    utility = np.array([1.0, 4.0, 16.0, 1 / 16, 1.9, 2.1, 1e9, np.inf, 1e-9, 0.0])
    assert grades(utility).tolist() == [0, 1, 2, -2, 0, 1, 3, 3, -4, -4]


def test_taken_rows_are_those_of_both_figures() -> None:
    found = SetUtility(np.arange(4.0), np.arange(4.0) + 10).take(np.array([3, 1]))
    assert (found.shown.tolist(), found.missed.tolist()) == ([3, 1], [13, 11])
