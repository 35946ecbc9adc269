from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.codec.quantise import fit, fit_rotation, largest_component, quats_from_smallest_three

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.floats(-20, 25), st.floats(-20, 25), st.floats(-6, 2), st.booleans())
def test_every_value_decodes_within_the_bound(
    seed: int, spread: float, offset: float, bound: float, zero: bool
) -> None:
    rng = np.random.default_rng(seed)
    values = (rng.normal(size=(50, 3)) * 10.0**spread + rng.normal() * 10.0**offset).astype(np.float32)
    exact = values.astype(np.float64)
    grid = fit(exact, 10.0**bound, zero=zero)
    decoded = grid.decode(grid.encode(exact))
    assert decoded.dtype == np.float32
    assert np.abs(decoded.astype(np.float64) - exact).max() <= grid.bound
    assert 1 <= grid.bits <= 24


def test_the_bound_is_the_one_asked_for_where_float32_allows_it() -> None:
    values = np.linspace(-3.0, 3.0, 100)[:, None]
    assert fit(values, 1e-3).bound == pytest.approx(1e-3, rel=1e-6)
    assert fit(values + 1e6, 1e-3).bound > 0.1


@given(seeds, st.floats(-6, 3))
def test_zero_is_kept_exactly(seed: int, spread: float) -> None:
    values = np.random.default_rng(seed).normal(size=(30, 3)) * 10.0**spread
    values[7] = 0
    grid = fit(values, 1e-3, zero=True)
    np.testing.assert_array_equal(grid.decode(grid.encode(values))[7], [0, 0, 0])


def test_equal_values_need_one_bit_and_are_exact() -> None:
    values = np.full((4, 2), 0.1, np.float32).astype(np.float64)
    grid = fit(values, 0.5)
    assert grid.bits == 1
    np.testing.assert_array_equal(grid.decode(grid.encode(values)), values)


@given(seeds, st.sampled_from([0.1, 0.01, 0.0025, 1e-4]))
def test_rotations_decode_within_the_bound(seed: int, error: float) -> None:
    quats = np.random.default_rng(seed).normal(size=(200, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    grid = fit_rotation(error)
    index, three = largest_component(quats)
    decoded = quats_from_smallest_three(index, grid.decode(grid.encode(three))).astype(np.float64)
    distance = np.minimum(np.linalg.norm(decoded - quats, axis=1), np.linalg.norm(decoded + quats, axis=1))
    assert distance.max() <= grid.bound <= error
    np.testing.assert_allclose(np.linalg.norm(decoded, axis=1), 1, atol=1e-6)


def test_rotations_about_no_axis_or_one_are_exact() -> None:
    quats = np.concatenate([np.eye(4), -np.eye(4)])
    grid = fit_rotation(0.0025)
    index, three = largest_component(quats)
    decoded = quats_from_smallest_three(index, grid.decode(grid.encode(three)))
    np.testing.assert_array_equal(decoded, np.abs(quats))
