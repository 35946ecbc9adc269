"""Nearest neighbours, against all distances."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.neighbours import mean_neighbour_distance, nearest_neighbours, thin


def every_distance(xyz: np.ndarray, count: int = 3) -> np.ndarray:
    distances = np.linalg.norm(xyz[:, None].astype(float) - xyz, axis=2)
    np.fill_diagonal(distances, np.inf)
    return np.sort(distances, axis=1)[:, :count].mean(axis=1)


@pytest.mark.parametrize("flat", [False, True])
def test_distances_are_close_to_the_true_ones(flat: bool) -> None:
    xyz = np.random.default_rng(0).normal(size=(1500, 3)) * (10, 5, 0 if flat else 2) + 100
    ratio = mean_neighbour_distance(xyz) / every_distance(xyz)
    assert ratio.min() > 0.999
    assert np.median(ratio) < 1.02
    assert ratio.mean() < 1.1


@pytest.mark.parametrize("points", [61, 3_000])
def test_sixty_neighbours_are_others_and_nearly_the_nearest(points: int) -> None:
    xyz = np.random.default_rng(1).normal(size=(points, 3)) * (10, 5, 2)
    found = nearest_neighbours(xyz, 60)
    assert found.shape == (points, 60)
    assert all(len(set(row) - {number}) == 60 for number, row in enumerate(found.tolist()))
    apart = np.linalg.norm(xyz[found] - xyz[:, None], axis=2).mean(axis=1)
    assert np.quantile(apart / every_distance(xyz, 60), 0.95) < 1.1


def test_too_few_points_have_no_neighbours() -> None:
    with pytest.raises(ValueError, match="3 points have no 3 neighbours"):
        nearest_neighbours(np.eye(3), 3)


def test_four_points_know_each_other() -> None:
    xyz = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
    np.testing.assert_allclose(mean_neighbour_distance(xyz), every_distance(xyz), rtol=1e-6)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_too_few_points_have_no_distance(count: int) -> None:
    np.testing.assert_array_equal(mean_neighbour_distance(np.ones((count, 3))), np.zeros(count))


def test_coinciding_points_are_at_distance_zero() -> None:
    np.testing.assert_array_equal(mean_neighbour_distance(np.ones((9, 3))), np.zeros(9))


def test_thinning_keeps_the_first_of_each_cube() -> None:
    xyz = np.array([[0.1, 0, 0], [0.2, 0, 0], [1.1, 0, 0], [-0.1, 0, 0], [1.2, 0, 0]])
    assert thin(xyz, 1.0).tolist() == [0, 2, 3]
    assert thin(xyz, 0.0).tolist() == [0, 1, 2, 3, 4]
