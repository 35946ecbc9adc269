"""Codes of appearance: near their values, and cheap where nothing shows them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.codec.encoder.appearance import appearance_numbers, rotation_numbers, turning_cost
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.rotation_coding import shape_error, vector_to_quats
from hgs_core.codec.encoder.steps import Steps
from hgs_core.scene.rotations import matrices, product
from tests.hgs_core.codec.encoder.prepared import prepared

SETTINGS = EncodeSettings()
COUNT = 400


def entropy(numbers: np.ndarray) -> float:
    """Bits a splat that an ideal coder needs for numbers [N, C], components apart."""
    counts = [np.unique(column, return_counts=True)[1] / len(numbers) for column in numbers.T]
    return float(sum(-(share * np.log2(share)).sum() for share in counts))


def units(count: int = COUNT, seed: int = 0) -> np.ndarray:
    quats = np.random.default_rng(seed).normal(size=(count, 4))
    quats[:, 0] = np.abs(quats[:, 0]) + 1
    return quats / np.linalg.norm(quats, axis=1, keepdims=True)


def test_colours_and_opacities_are_within_a_step_and_a_half_of_what_they_stand_for() -> None:
    rng = np.random.default_rng(0)
    splats = prepared(COUNT, rgb=rng.uniform(0, 1, (COUNT, 3)), opacity=rng.uniform(0.01, 0.99, COUNT))
    steps = Steps.of(splats, SETTINGS)
    numbers = appearance_numbers(splats, steps)
    assert np.abs(numbers["rgb"] * steps.rgb - splats.rgb).max() <= 1.5 * steps.rgb + 1e-9
    x = np.clip(numbers["opacity"] * steps.opacity, 0, 1)
    eased = x * x * (3 - 2 * x)  # docs/format.md; its slope is at most 1.5
    assert np.abs(eased - splats.opacity).max() <= 1.5 * 1.5 * steps.opacity + 1e-9


def test_no_splat_loses_its_opacity() -> None:
    splats = prepared(COUNT, opacity=np.full(COUNT, 1e-5))
    steps = dataclasses.replace(Steps.of(splats, SETTINGS), opacity=0.06)
    assert appearance_numbers(splats, steps)["opacity"].min() == 1


def test_splats_that_show_less_than_the_chunks_finest_have_cheaper_numbers() -> None:
    rgb = np.random.default_rng(0).normal(0.5, 0.04, (COUNT, 3))
    found = []
    for weak in (1.0, 1 / 16):
        splats = prepared(COUNT, rgb=rgb, utility=np.where(np.arange(COUNT) == 0, 1.0, weak))
        numbers = appearance_numbers(splats, Steps.of(splats, SETTINGS))["rgb"]
        differences = np.concatenate([numbers[:, :1], np.diff(numbers, axis=1)], axis=1)  # the counted form of colours
        found.append(entropy(differences))
    assert found[1] < 0.9 * found[0]


def test_sizes_are_within_steps_once_they_are_blurred_and_thin_axes_cost_next_to_nothing() -> None:
    rng = np.random.default_rng(0)
    thin = rng.normal(-12, 1.5, COUNT)  # far below the blur, whose deviation is 1e-3 here
    sizes = np.stack([rng.normal(-2, 0.4, COUNT), rng.normal(-3, 0.4, COUNT), thin], axis=1)
    splats = prepared(COUNT, log_scale=sizes)
    steps = Steps.of(splats, SETTINGS)
    numbers = appearance_numbers(splats, steps)["log_scale"]
    same = np.tile([1.0, 0, 0, 0], (COUNT, 1))
    assert shape_error(same, sizes, same, numbers * steps.shape, steps.blur).max() <= 1.5 * steps.shape + 1e-3
    assert len(np.unique(numbers[:, 2])) <= 3
    assert np.abs(numbers[:, :2] * steps.shape - sizes[:, :2]).max() <= 1.5 * steps.shape + 1e-3


def test_where_thin_axes_decide_how_strong_a_splat_is_they_are_told() -> None:
    rng = np.random.default_rng(0)
    sizes = np.stack([np.full(COUNT, -2.0), np.full(COUNT, -3.0), rng.normal(-9, 0.5, COUNT)], axis=1)
    splats = prepared(COUNT, log_scale=sizes, strength_by_scale=[[0.0, 0.0, 1.0]])
    steps = Steps.of(splats, SETTINGS)
    numbers = appearance_numbers(splats, steps)["log_scale"]
    assert np.abs(numbers[:, 2] * steps.shape - sizes[:, 2]).mean() < 2 * steps.shape


@pytest.mark.parametrize(
    ("log_scale", "axis", "free"),
    [
        ((-2.0, -2.0, -2.0), 0, True),  # a ball
        ((-2.0, -5.0, -5.0), 0, True),  # a needle about its own axis
        ((-2.0, -5.0, -5.0), 1, False),
        ((-2.0, -2.0, -5.0), 2, True),  # a disc about its normal
        ((-2.0, -2.0, -5.0), 0, False),
    ],
)
def test_a_turn_that_leaves_the_ellipsoid_as_it_is_costs_nothing(
    log_scale: tuple[float, ...], axis: int, free: bool
) -> None:
    splats = prepared(1, log_scale=[log_scale])
    cost = turning_cost(splats, 0.1 * np.eye(3)[None, axis], np.ones(1))
    assert (cost[0] < 1e-12) == free


def test_a_turn_costs_the_square_of_angle_and_unevenness_in_squared_steps() -> None:
    """Of deviations of 3 and 1 pixels the unevenness is 3 - 1/3; a turn counts a third of a change of scale."""
    deviations = np.sqrt(np.array([9.0, 1.0, 1.0]) - 0.3) / 100
    splats = prepared(1, log_scale=np.log([deviations]))
    cost = turning_cost(splats, np.array([[[0.0, 0.1, 0.0], [0.0, 0.0, 0.2]]]), np.array([0.5]))
    np.testing.assert_allclose(cost, [[(8 / 3 * 0.1) ** 2 / 3 / 0.25, (8 / 3 * 0.2) ** 2 / 3 / 0.25]])
    strong = prepared(1, log_scale=np.log([deviations]), strength_by_turn=[[7.0, 0.0, 0.0]])
    np.testing.assert_allclose(turning_cost(strong, np.array([[0.1, 0.0, 0.0]]), np.array([0.5])), [7 * 0.01 / 0.25])


def decoded(splats_quats: np.ndarray, log_scale: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray, float]:
    """The numbers of rotations, the quaternions they stand for, and the step of shapes."""
    splats = prepared(len(splats_quats), log_scale=[log_scale], rotation=splats_quats)
    steps = Steps.of(splats, SETTINGS)
    numbers = rotation_numbers(splats, splats_quats, steps)
    return numbers, vector_to_quats(numbers * steps.rotation), steps.shape


def test_rotations_of_uneven_splats_are_kept_to_a_few_steps_of_their_shape() -> None:
    quats, sizes = units(), (-1.0, -2.0, -3.0)
    _, found, step = decoded(quats, sizes)
    scales = np.tile(sizes, (COUNT, 1))
    assert shape_error(quats, scales, found, scales, 1e-3).max() < 5 * step
    assert np.median(shape_error(quats, scales, found, scales, 1e-3)) < 2 * step


def test_a_ball_has_no_rotation() -> None:
    assert not decoded(units(), (-2.0, -2.0, -2.0))[0].any()


def test_a_needle_keeps_its_direction_and_is_cheaper_than_a_splat_of_three_axes() -> None:
    quats = units()
    needles, found, _ = decoded(quats, (-1.0, -3.0, -3.0))
    direction, told = (matrices(q)[:, :, 0] for q in (quats, found))
    assert np.degrees(np.arccos(np.clip(np.abs((direction * told).sum(axis=1)), 0, 1))).max() < 3
    assert (needles == 0).any(axis=1).mean() > 0.3
    twisted = product(quats, np.stack([np.cos(a := np.linspace(0, 1, COUNT)), np.sin(a), 0 * a, 0 * a], axis=1))
    again = matrices(decoded(twisted * np.where(twisted[:, :1] < 0, -1, 1), (-1.0, -3.0, -3.0))[1])[:, :, 0]
    assert np.abs((direction * again).sum(axis=1)).min() > np.cos(np.radians(3))
    assert entropy(needles) < entropy(decoded(quats, (-1.0, -2.0, -3.0))[0]) - 1
