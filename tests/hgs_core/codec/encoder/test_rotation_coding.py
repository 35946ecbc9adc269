from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.codec.encoder.rotation_coding import canonical, shape_error, turn_between
from hgs_core.scene.rotations import matrices, product

seeds = st.integers(0, 2**32 - 1)


def units(seed: int, count: int = 50) -> np.ndarray:
    quats = np.random.default_rng(seed).normal(size=(count, 4))
    return quats / np.linalg.norm(quats, axis=1, keepdims=True)


def covariances(quats: np.ndarray, log_scales: np.ndarray) -> np.ndarray:
    axes = matrices(quats) * np.exp(log_scales)[:, None, :]
    return axes @ np.swapaxes(axes, 1, 2)


@given(seeds)
def test_canonical_splats_are_the_same_ellipsoids_with_falling_axes_and_a_large_w(seed: int) -> None:
    quats = units(seed)
    log_scales = np.random.default_rng(seed).normal(size=(50, 3))
    turn, falling = canonical(quats, log_scales)
    turned = product(quats, turn)
    np.testing.assert_allclose(covariances(turned, falling), covariances(quats, log_scales), rtol=1e-9, atol=1e-12)
    assert (np.diff(falling, axis=1) <= 0).all()
    assert (np.abs(turned[:, 0]) >= 0.5 - 1e-12).all()


def test_a_small_turn_is_measured_about_the_splats_own_axes() -> None:
    quats = units(3)
    turn = np.array([0.01, -0.02, 0.03])
    small = np.concatenate([[np.sqrt(1 - (turn**2).sum() / 4)], turn / 2])
    np.testing.assert_allclose(turn_between(quats, -product(quats, small)), np.tile(turn, (50, 1)), atol=1e-12)


def test_the_shape_error_is_the_largest_ratio_over_many_directions() -> None:
    rng = np.random.default_rng(0)
    scales, other_scales = rng.normal(size=(50, 3)), rng.normal(size=(50, 3))
    a, b = (covariances(units(s), x) + 0.3**2 * np.eye(3) for s, x in ((1, scales), (2, other_scales)))
    directions = rng.normal(size=(20_000, 3))
    ratio = np.einsum("ki,nij,kj->nk", directions, b, directions) / np.einsum(
        "ki,nij,kj->nk", directions, a, directions
    )
    sampled = np.abs(np.log(ratio)).max(axis=1) / 2
    error = shape_error(units(1), scales, units(2), other_scales, 0.3)
    assert (sampled <= error + 1e-9).all()
    np.testing.assert_allclose(sampled, error, rtol=0.02)


@given(seeds)
def test_the_shape_error_has_a_number_for_axes_of_any_lengths(seed: int) -> None:
    """From e^-30 to e^30 beside a blur of any size; without a turn it is the largest ratio of two axes."""
    rng = np.random.default_rng(seed)
    scales, others = rng.uniform(-30, 30, (2, 50, 3))
    blur = float(np.exp(rng.uniform(-20, 20)))
    thick, other = (np.logaddexp(2 * x, 2 * np.log(blur)) / 2 for x in (scales, others))
    assert np.isfinite(shape_error(units(seed), scales, units(seed + 1), others, blur)).all()
    still = np.tile([1.0, 0, 0, 0], (50, 1))
    exact = shape_error(still, scales, still, others, blur)
    np.testing.assert_allclose(exact, np.abs(thick - other).max(axis=1), atol=1e-9)
