"""Matches of cameras without poses, against points with known projections."""

from __future__ import annotations

import numpy as np

from hgs_core.points.features import Features
from hgs_core.points.matching import likely_pairs, match_moments, moving_pixels
from tests.rigs import dome

EMPTY = Features(np.zeros((0, 2)), np.zeros((0, 128), np.float32))


def descriptors(numbers: np.random.Generator, count: int) -> np.ndarray:
    values = numbers.integers(0, 100, (count, 128)).astype(np.float64)
    return (values * 512 / np.linalg.norm(values, axis=1, keepdims=True)).round().clip(0, 255).astype(np.float32)


def seen(count: int = 40, moments: int = 2, seed: int = 1) -> list[list[Features]]:
    """Two cameras that see other points in each moment."""
    numbers, cameras = np.random.default_rng(seed), dome(8)
    views: list[list[Features]] = [[], []]
    for _ in range(moments):
        points = numbers.uniform(-1, 1, (count, 3)) + np.array([5.0, 0.0, 2.0])
        stored = descriptors(numbers, count)
        for view, camera in zip(views, (cameras[0], cameras[1]), strict=True):
            view.append(Features(camera.project(points)[0], stored))
    return views


def test_matches_of_all_moments_are_joined_with_their_rows() -> None:
    first, second = seen()
    found = match_moments(first, second)
    assert found is not None
    assert len(found.rows) == 80
    assert found.rows.tolist() == [[row, row] for row in range(80)]
    np.testing.assert_array_equal(found.moments, np.repeat([0, 1], 40))
    np.testing.assert_array_equal(found.second, np.concatenate([one.xy for one in second]))


def test_features_are_matched_within_their_moment_alone() -> None:
    first, second = seen()
    assert match_moments([first[0], EMPTY], [EMPTY, second[0]]) is None


def test_a_few_points_on_no_geometry_are_left_out_and_many_refuse_the_pair() -> None:
    first, second = seen()
    spoilt = [Features(one.xy.copy(), one.descriptors) for one in second]
    spoilt[0].xy[:8, 1] += 50
    found = match_moments(first, spoilt)
    assert found is not None
    assert set(found.rows[:, 0].tolist()) <= set(range(8, 80))
    scattered = np.random.default_rng(0).uniform(0, 480, (80, 2))
    assert match_moments(first, [Features(scattered[:40], second[0].descriptors), EMPTY]) is None


def test_of_many_cameras_only_those_that_see_alike_are_paired() -> None:
    numbers = np.random.default_rng(2)
    groups = [descriptors(numbers, 30) for _ in range(2)]
    features = [[Features(np.zeros((30, 2)), groups[camera % 2])] for camera in range(16)]
    pairs = likely_pairs(features)
    assert pairs
    assert all((a - b) % 2 == 0 for a, b in pairs)
    assert len(likely_pairs(features[:5])) == 10


def test_what_differs_from_the_median_of_all_moments_moves() -> None:
    pictures = [np.full((4, 6, 3), 100, np.uint8) for _ in range(5)]
    pictures[2][1, 3] = 180
    found = moving_pixels(pictures)
    assert [int(mask.sum()) for mask in found] == [0, 0, 1, 0, 0]
    assert found[2][1, 3]
