from __future__ import annotations

import math

import numpy as np
import pytest

from hgs_core.scene import DynamicSplats, evaluate, lifetime
from hgs_core.scene.motion import COEFFICIENTS, coefficients_of_order
from hgs_core.scene.splats import joined


def splat(**fields: object) -> DynamicSplats:
    base = {name: np.zeros((1, *array.shape[1:]), np.float32) for name, array in DynamicSplats.empty().items()}
    base["rotation"][0, 0, 0] = 1
    for name, value in fields.items():
        base[name] = np.asarray([value], np.float32)
    return DynamicSplats(**base)


def test_the_opacity_is_one_255th_at_both_ends_of_the_lifetime() -> None:
    one = splat(opacity_logits=2.0, time_centers=0.3, time_log_precisions=3.0)
    (start,), (end,) = lifetime(one)
    assert start < 0.3 < end
    for t in (start, end):
        assert evaluate(one, t)[2][0] == pytest.approx(1 / 255, rel=1e-9)


def test_a_splat_below_one_255th_never_lives() -> None:
    (start,), (end,) = lifetime(splat(opacity_logits=-5.6))
    assert (start, end) == (math.inf, -math.inf)


def test_a_splat_without_precision_always_lives() -> None:
    (start,), (end,) = lifetime(splat(opacity_logits=0.0, time_log_precisions=-1e4))
    assert (start, end) == (-math.inf, math.inf)
    assert evaluate(splat(time_log_precisions=-1e4), 100.0)[2][0] == pytest.approx(0.5)


def test_a_splat_of_endless_precision_lives_at_its_centre_alone() -> None:
    one = splat(time_centers=0.25, time_log_precisions=1e4)
    (start,), (end,) = lifetime(one)
    assert (start, end) == (0.25, 0.25)
    assert evaluate(one, 0.25)[2][0] == pytest.approx(0.5)
    assert evaluate(one, 0.26)[2][0] == 0


@pytest.mark.parametrize("coefficients", COEFFICIENTS)
def test_the_position_is_the_polynomial(coefficients: int) -> None:
    """Reference: numpy.polynomial."""
    motion = np.random.default_rng(0).normal(size=(coefficients, 3))
    positions, _, _ = evaluate(splat(motion=motion, time_centers=0.5), 0.75)
    expected = np.polynomial.polynomial.polyval(0.25, motion.astype(np.float32).astype(np.float64))
    np.testing.assert_allclose(positions[0], expected, rtol=1e-12)


def test_an_order_is_kept_in_the_least_coefficients_that_there_are() -> None:
    assert [coefficients_of_order(order) for order in (1, 2, 3, 5)] == [4, 4, 4, 6]
    with pytest.raises(ValueError, match="highest order is 5"):
        coefficients_of_order(6)


def test_joined_sets_move_as_before_whatever_their_orders() -> None:
    r = np.random.default_rng(1)
    sets = [splat(motion=r.normal(size=(k, 3)), time_centers=0.5) for k in (4, 6, 4)]
    together = joined(sets)
    assert together.motion.shape == (3, 6, 3)
    expected = np.concatenate([evaluate(one, 0.9)[0] for one in sets])
    np.testing.assert_allclose(evaluate(together, 0.9)[0], expected, rtol=1e-15)


def test_the_rotation_is_linear_then_normalised_and_safe_at_zero() -> None:
    turning = splat(rotation=[[1, 0, 0, 0], [0, 2, 0, 0]])
    np.testing.assert_allclose(evaluate(turning, 0.5)[1][0], np.array([1, 1, 0, 0]) / math.sqrt(2))
    zero = splat(rotation=[[1, 0, 0, 0], [-1, 0, 0, 0]])
    np.testing.assert_array_equal(evaluate(zero, 1.0)[1][0], [1, 0, 0, 0])
