from __future__ import annotations

import numpy as np

from hgs_core.scene.rotations import matrices, product, quaternions_of, unit_quaternions, units_and_norms


def test_quaternions_get_unit_length_and_those_of_no_length_are_the_identity() -> None:
    given = np.array([[0, 3, 0, -4], [0, 0, 0, 0], [1e-13, 0, 0, 0], [2, 0, 0, 0]], np.float32)
    units, norms = units_and_norms(given)
    np.testing.assert_allclose(units, [[0, 0.6, 0, -0.8], [1, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]])
    np.testing.assert_array_equal(norms, [[5], [1], [1], [2]])
    np.testing.assert_array_equal(unit_quaternions(given), units)


def test_a_matrix_turns_vectors_as_its_quaternion_does() -> None:
    """q v q* by Hamilton's rules, written out for a turn by an angle about an axis: Rodrigues' formula."""
    rng = np.random.default_rng(0)
    axis, angle, v = np.array([2.0, -1.0, 2.0]) / 3, 0.7, rng.normal(size=3)
    quat = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis])
    turned = v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1 - np.cos(angle))
    np.testing.assert_allclose(matrices(quat) @ v, turned, atol=1e-15)


def test_quaternions_are_found_again_from_their_matrices_with_w_at_least_zero() -> None:
    quats = unit_quaternions(np.concatenate([np.random.default_rng(1).normal(size=(200, 4)), np.eye(4), -np.eye(4)]))
    found = quaternions_of(matrices(quats))
    assert (found[:, 0] >= 0).all()
    np.testing.assert_allclose(np.abs((found * quats).sum(axis=1)), 1, atol=1e-12)
    np.testing.assert_allclose(matrices(found), matrices(quats), atol=1e-12)


def test_a_product_turns_by_the_second_then_the_first() -> None:
    a, b = (unit_quaternions(np.random.default_rng(seed).normal(size=(50, 4))) for seed in (0, 1))
    np.testing.assert_allclose(matrices(product(a, b)), matrices(a) @ matrices(b), atol=1e-12)
