"""Normals of points on surfaces with known normals."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.surface_normals import surface_normals


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.6, -0.8, 0.0), (0.48, 0.6, 0.64)])
def test_points_of_a_wall_face_across_it(normal: tuple[float, float, float]) -> None:
    """2,000 points on 16 square units, a hundredth of a unit beside the wall."""
    random, across = np.random.default_rng(0), np.array(normal)
    one = np.cross(across, (0.3, 0.2, 0.9))
    one /= np.linalg.norm(one)
    places = random.uniform(-2, 2, (2_000, 2)) @ np.stack([one, np.cross(across, one)])
    found = surface_normals(places + random.normal(0, 0.01, (2_000, 1)) * across + 7)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-5)
    assert np.quantile(np.abs(found @ across), 0.01) > 0.99


def test_points_of_a_ball_face_outwards() -> None:
    random = np.random.default_rng(1)
    outwards = random.normal(size=(4_000, 3))
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    assert np.quantile(np.abs((surface_normals(3 * outwards) * outwards).sum(1)), 0.05) > 0.99


def test_points_in_all_directions_lie_on_no_surface() -> None:
    found = surface_normals(np.random.default_rng(2).normal(size=(2_000, 3)))
    assert (found == 0).all(axis=1).mean() > 0.9


@pytest.mark.parametrize("count", [0, 1, 3])
def test_few_points_make_no_surface(count: int) -> None:
    np.testing.assert_array_equal(surface_normals(np.ones((count, 3))), np.zeros((count, 3)))


def test_points_on_a_line_lie_on_no_surface_that_is_known() -> None:
    found = surface_normals(np.linspace(0, 1, 200)[:, None] * (1.0, 2.0, 3.0))
    np.testing.assert_array_equal(found, np.zeros((200, 3)))
