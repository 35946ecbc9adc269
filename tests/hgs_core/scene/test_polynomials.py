"""Fits of polynomials against the polynomials that were sampled, and against numpy's own fit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.scene.polynomials import polynomial_fit, powers

finite = st.floats(-10, 10, allow_nan=False)


@given(st.lists(finite, min_size=4, max_size=4), st.floats(-6, 6), st.floats(0.05, 2.0))
def test_a_cubic_is_found_again_wherever_it_is_sampled(coefficients: list[float], first: float, length: float) -> None:
    offsets = first + length * np.linspace(0, 1, 9)[None]
    goal = np.polynomial.polynomial.polyval(offsets, coefficients)[..., None]
    found = polynomial_fit(offsets, 3, goal, np.full((1, 9), 1 / 9))
    size = 1 + np.abs(powers(offsets, 3) * coefficients).sum(2).max()
    np.testing.assert_allclose(powers(offsets, 3) @ found, goal, rtol=0, atol=1e-8 * size)


@pytest.mark.parametrize("order", [1, 2, 5])
def test_it_is_the_weighted_fit_of_numpy(order: int) -> None:
    generator = np.random.default_rng(order)
    offsets = np.sort(generator.normal(size=(1, 12)), axis=1)
    goal, weights = generator.normal(size=(1, 12, 1)), generator.uniform(0.1, 1, (1, 12))
    expected = np.polyfit(offsets[0], goal[0, :, 0], order, w=np.sqrt(weights[0]))[::-1]
    np.testing.assert_allclose(polynomial_fit(offsets, order, goal, weights)[0, :, 0], expected, rtol=1e-6, atol=1e-8)


def test_an_instant_is_a_constant() -> None:
    found = polynomial_fit(np.full((1, 9), 0.3), 3, np.full((1, 9, 1), 2.0), np.full((1, 9), 1 / 9))
    np.testing.assert_allclose(found[0, :, 0], [2, 0, 0, 0], atol=1e-9)
