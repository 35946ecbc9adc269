from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.codec.format.quantise import Grid, eased, fitting_grid, uneased, unit_quats

whole = st.integers(-(1 << 23), 1 << 23)
rows = st.lists(st.tuples(whole, whole, whole), min_size=1, max_size=30)


@given(rows, st.booleans(), st.floats(-6, 3))
def test_numbers_come_back_as_multiples_of_the_step_rounded_once(
    numbers: list[tuple[int, int, int]], common: bool, size: float
) -> None:
    values = np.array(numbers, np.int64)
    step = float(np.float32(10.0**size))
    if values.max() - values.min() >= 1 << 24:
        return
    grid, codes = fitting_grid(values, step, common=common)
    assert (codes < 1 << grid.bits).all()
    if common:
        assert len(set(grid.zeros)) == 1
    decoded = grid.decode(codes.T)
    np.testing.assert_array_equal(decoded, (values * step).astype(np.float32))


@pytest.mark.parametrize("step", [0.1, 1e-44, 3e38])
@pytest.mark.parametrize("zero", [77, (1 << 24) - 256, (1 << 24) - 255, -(1 << 28)])
def test_a_grid_near_zero_and_one_far_from_it_give_the_bits_of_the_formula(step: float, zero: int) -> None:
    grid = Grid(float(np.float32(step)), (zero, -zero), 8)
    codes = np.tile(np.arange(256, dtype=np.uint8), (2, 1))
    with np.errstate(over="ignore"):
        exact = ((codes.T - np.array([zero, -zero], np.float64)) * grid.step).astype(np.float32)
        np.testing.assert_array_equal(grid.decode(codes), exact)


def test_numbers_too_far_apart_are_refused() -> None:
    with pytest.raises(ValueError, match="too many steps apart"):
        fitting_grid(np.array([[0], [1 << 24]]), 1.0)


@given(st.floats(0, 1))
def test_easing_is_undone(opacity: float) -> None:
    x = uneased(np.array([opacity]))
    assert 0 <= x[0] <= 1
    np.testing.assert_allclose(eased(x), [opacity], atol=1e-12)


def test_what_lies_outside_is_limited_before_it_is_eased() -> None:
    assert eased(np.array([-3.0, 0.0, 0.5, 1.0, np.inf])).tolist() == [0, 0, 0.5, 1, 1]


@given(st.integers(0, 2**32 - 1))
def test_the_first_component_makes_quaternions_unit(seed: int) -> None:
    quats = np.random.default_rng(seed).normal(size=(20, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True) * np.where(quats[:, :1] < 0, -1, 1)
    np.testing.assert_allclose(unit_quats(quats[:, 1:].astype(np.float32)), quats, atol=2e-3)
