"""Reference: the strength sqrt(det C0 / det C) itself, differentiated by differences, over the same directions."""

from __future__ import annotations

import numpy as np

from hgs_core.codec.encoder.antialiased_weights import GOLDEN_ANGLE, VIEW_DIRECTIONS, strength_weights
from hgs_core.scene.rotations import matrices


def strength(deviations: np.ndarray, turn: np.ndarray, view: np.ndarray) -> float:
    """ln of the square root of det C0 / det C, the ellipsoid turned about its axes and seen along `view`."""
    axes = matrices(np.concatenate([[1.0], turn / 2]) / np.linalg.norm(np.concatenate([[1.0], turn / 2])))
    covariance = axes @ np.diag(deviations**2) @ axes.T
    side = np.cross(view, [1.0, 0.0, 0.0] if abs(view[0]) < 0.9 else [0.0, 1.0, 0.0])
    side /= np.linalg.norm(side)
    plane = np.stack([side, np.cross(view, side)])
    seen = plane @ covariance @ plane.T
    return 0.5 * float(np.log(np.linalg.det(seen) / np.linalg.det(seen + 0.3 * np.eye(2))))


def test_weights_are_mean_squares_of_derivatives() -> None:
    for deviations in ([2.0, 1.0, 0.5], [5.0, 0.7, 0.02], [3.0, 2.5, 0.01]):
        given = np.array(deviations)
        scale, turn = np.zeros(3), np.zeros(3)
        for i in range(VIEW_DIRECTIONS):
            z = (i + 0.5) / VIEW_DIRECTIONS
            across = np.sqrt(1 - z * z)
            view = np.array([across * np.cos(GOLDEN_ANGLE * i), across * np.sin(GOLDEN_ANGLE * i), z])
            for axis in range(3):
                step = 1e-5 * np.eye(3)[axis]
                up, down = (strength(given * np.exp(s * step), np.zeros(3), view) for s in (1, -1))
                scale[axis] += ((up - down) / 2e-5) ** 2 / VIEW_DIRECTIONS
                up, down = (strength(given, s * step, view) for s in (1, -1))
                turn[axis] += ((up - down) / 2e-5) ** 2 / VIEW_DIRECTIONS
        found = strength_weights(given[None])
        np.testing.assert_allclose(found[0][0], scale, rtol=1e-3, atol=1e-6)
        np.testing.assert_allclose(found[1][0], turn, rtol=1e-3, atol=1e-6)


def test_splats_much_larger_than_a_pixel_keep_their_strength() -> None:
    scale, turn = strength_weights(np.full((1, 3), 50.0))
    assert scale.max() < 1e-6
    assert turn.max() < 1e-6
