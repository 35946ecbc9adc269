"""Polynomials of motion and of turning, against numpy's along each splat's visible life."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.codec.encoder.encode_chunk import LIMITS
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.motion_coding import CHECKED_MOMENTS, Path, highest_order, motion_numbers, turning_numbers
from hgs_core.codec.encoder.prepare import PreparedDynamics
from hgs_core.codec.encoder.rotation_coding import shape_error, vector_to_quats
from hgs_core.codec.encoder.steps import Steps
from tests.hgs_core.codec.encoder.prepared import prepared

NAMES = ("position", "velocity", "acceleration", "jerk", "snap", "crackle")
COUNT = 60
Polynomial = np.polynomial.polynomial


def moving(order: int, size: float = 1.0, count: int = COUNT) -> PreparedDynamics:
    """Splats that swing in the polynomial of this order that no lower one comes near to (Chebyshev's, in [0, 1])."""
    rng = np.random.default_rng(order)
    swing = np.polynomial.chebyshev.cheb2poly([0] * order + [size]) * 2.0 ** np.arange(order + 1)
    motion = np.zeros((count, 6 if order > 3 else 4, 3))
    motion[:, : order + 1] = swing[:, None] * rng.uniform(0.5, 1, (count, 1, 3))
    motion[:, 0] += rng.normal(size=(count, 3))
    return prepared(
        count, log_scale=np.log(0.05), **{name: motion[:, k] for k, name in enumerate(NAMES[: motion.shape[1]])}
    )


def path_of(splats: PreparedDynamics) -> tuple[Path, np.ndarray]:
    """The path over the whole segment, and its times from the middle."""
    path = Path.of(splats, np.zeros(len(splats)), np.ones(len(splats)))
    return path, path.times - 0.5


def rebuilt(numbers: dict[str, tuple[np.ndarray, float]], orders: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Positions [N, J, 3] that the numbers stand for."""
    found = np.zeros((*offsets.shape, 3))
    for k, name in enumerate(NAMES):
        if name in numbers:
            whole, step = numbers[name]
            members = orders >= k
            assert len(whole) == members.sum(), name
            found[members] += (whole * step)[:, None] * offsets[members, :, None] ** k
    return found


def test_a_path_is_what_the_polynomials_say_at_equal_moments_of_the_visible_life() -> None:
    rng = np.random.default_rng(0)
    arrays = {name: rng.normal(size=(5, 3)) for name in NAMES[:4]}
    turn = {"rotation": rng.normal(size=(5, 4)), "turning": rng.normal(size=(5, 4))}
    splats = prepared(5, time_center=np.full(5, 0.3), time_log_precision=np.full(5, 2.0), **arrays, **turn)
    path = Path.of(splats, np.full(5, 0.1), np.full(5, 0.9))
    times = np.linspace(0.1, 0.9, CHECKED_MOMENTS)
    np.testing.assert_allclose(path.times, np.tile(times, (5, 1)))
    np.testing.assert_allclose(path.fade[2], np.exp(-np.exp(2.0) * (times - 0.3) ** 2))
    for axis in range(3):
        expected = Polynomial.polyval(times - 0.3, [arrays[name][4, axis] for name in NAMES[:4]])
        np.testing.assert_allclose(path.positions[4, :, axis], expected)
    quat = turn["rotation"][1] + (times[3] - 0.3) * turn["turning"][1]
    np.testing.assert_allclose(path.quats[1, 3], quat / np.linalg.norm(quat))
    np.testing.assert_allclose(path.weights.sum(axis=1), 1)
    ratio = path.weights[0, 0] / path.weights[0, 5]
    np.testing.assert_allclose(ratio, (path.fade[0, 0] / path.fade[0, 5]) ** 2, rtol=1e-6)


def test_a_rotation_that_passes_through_nothing_is_none_there() -> None:
    splats = prepared(1, rotation=[[-0.5, 0, 0, 0]], turning=[[1.0, 0, 0, 0]], time_center=[0.0])
    assert Path.of(splats, np.zeros(1), np.ones(1)).quats[0, 4].tolist() == [1, 0, 0, 0]


@pytest.mark.parametrize("order", [0, 1, 2, 3, 5])
def test_the_order_taken_is_the_lowest_that_the_path_needs_and_the_path_is_kept(order: int) -> None:
    splats = moving(order)
    steps, (path, offsets) = Steps.of(splats, EncodeSettings()), path_of(splats)
    numbers, orders = motion_numbers(path, offsets, steps, highest_order(splats))
    assert (orders == order).all()
    assert set(numbers) == set(NAMES[: order + 1])
    assert np.abs(rebuilt(numbers, orders, offsets) - path.positions).max() < 4 * steps.position


@pytest.mark.parametrize("order", [3, 5])
def test_roundings_that_few_splats_would_bear_do_not_add_up_to_more_than_a_chunk_may_be_off(order: int) -> None:
    """Splats that show next to nothing in a chunk of others: bits count for them, and errors hardly do."""
    rng, count = np.random.default_rng(0), 3000
    motion = {name: rng.normal(size=(count, 3)) * (0.5 if k else 1.0) for k, name in enumerate(NAMES[: order + 1])}
    splats = prepared(count, log_scale=np.log(0.05), **motion)
    path, offsets = path_of(splats)
    steps = Steps.of(splats, EncodeSettings())
    steps = dataclasses.replace(steps, own_position=10 * steps.own_position)
    numbers, orders = motion_numbers(path, offsets, steps, order)
    error = np.abs(rebuilt(numbers, orders, offsets) - path.positions).max(axis=2) * path.fade
    assert 6 * steps.position < error.max() < LIMITS["position"] * steps.position


def test_what_moves_by_less_than_it_is_worth_stands_still_and_no_farther_than_three_steps_off() -> None:
    splats = moving(1, size=1e-4)
    steps, (path, offsets) = Steps.of(splats, EncodeSettings()), path_of(splats)
    assert np.abs(path.positions - path.positions.mean(axis=1, keepdims=True)).max() < steps.position / 4
    numbers, orders = motion_numbers(path, offsets, steps)
    assert not orders.any()
    assert set(numbers) == {"position"}


def test_no_order_above_the_highest_asked_is_taken() -> None:
    splats = moving(5)
    path, offsets = path_of(splats)
    numbers, orders = motion_numbers(path, offsets, Steps.of(splats, EncodeSettings()), 3)
    assert orders.max() == 3
    assert "snap" not in numbers


def turning(speed: float, count: int = COUNT) -> PreparedDynamics:
    """Uneven splats that turn about axes of their own; `speed` is the angle over the segment in radians, about."""
    rng = np.random.default_rng(1)
    quats = rng.normal((2, 0, 0, 0), 1, (count, 4))
    quats /= np.linalg.norm(quats, axis=1, keepdims=True)
    turn = rng.normal(size=(count, 4))
    turn -= (turn * quats).sum(axis=1, keepdims=True) * quats
    turn *= speed / 2 / np.linalg.norm(turn, axis=1, keepdims=True)
    return prepared(count, log_scale=[[-1.0, -2.0, -3.0]], rotation=quats, turning=turn)


@pytest.mark.parametrize("speed", [0.5, 2.0, 6.0])  # the last turns too far to be told by the vector part over w
def test_a_turn_is_followed_all_along_its_path(speed: float) -> None:
    splats = turning(speed)
    steps, (path, offsets) = Steps.of(splats, EncodeSettings()), path_of(splats)
    numbers, turns = turning_numbers(splats, path, offsets, np.zeros((COUNT, 1)), np.zeros(COUNT, np.int32), steps)
    assert turns.all()
    rotation, step = numbers["rotation"]
    rates, rate_step = numbers["turning"]
    quats = vector_to_quats(rotation * step)[:, None] + offsets[..., None] * (rates * rate_step)[:, None]
    quats /= np.linalg.norm(quats, axis=2, keepdims=True)
    sizes = splats.log_scale
    errors = [shape_error(path.quats[:, j], sizes, quats[:, j], sizes, 1e-3) for j in range(CHECKED_MOMENTS)]
    assert np.median(errors) < 2 * steps.shape
    assert np.max(errors) < 8 * steps.shape


def test_what_does_not_turn_has_no_turning() -> None:
    splats = turning(1e-4)
    path, offsets = path_of(splats)
    steps = Steps.of(splats, EncodeSettings())
    numbers, turns = turning_numbers(splats, path, offsets, np.zeros((COUNT, 1)), np.zeros(COUNT, np.int32), steps)
    assert not turns.any()
    assert set(numbers) == {"rotation"}
