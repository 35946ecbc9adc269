"""Reference: numpy's polyfit over the visible times of a splat, residuals times its remaining opacity."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.interchange.cubic import as_cubics
from hgs_core.scene import DynamicSplats
from tests.hgs_core.interchange.scenes import dynamics

FIFTH = np.array([50, 3, -2, 1, 8, -40], np.float32)
Polynomial = np.polynomial.polynomial


def one_of_the_fifth_order(log_precision: float) -> DynamicSplats[np.ndarray]:
    """Splats of which the first moves along x in the fifth order, at its brightest in the middle."""
    own = dynamics()
    motion = np.pad(own.motion, ((0, 0), (0, 2), (0, 0)))
    motion[0, :, 0] = FIFTH
    found = dataclasses.replace(own, motion=motion)
    found.time_centers[0], found.time_log_precisions[0], found.opacity_logits[0] = 0.5, log_precision, 5
    return found


@pytest.mark.parametrize("log_precision", [-20.0, 4.0])  # hardly fades; is seen for a third of the segment
def test_a_motion_of_the_fifth_order_becomes_the_cubic_nearest_to_what_is_seen(log_precision: float) -> None:
    given = one_of_the_fifth_order(log_precision)
    found, met, error = as_cubics(given)
    opacity = 1 / (1 + np.exp(-5.0))
    reach = min(0.5, np.sqrt(np.log(255 * opacity) / np.exp(log_precision)))
    d = np.linspace(-reach, reach, 33)
    fade = np.exp(-np.exp(log_precision) * d**2)
    path = Polynomial.polyval(d, FIFTH.astype(np.float64))
    expected = Polynomial.polyfit(d, path, 3, w=fade)
    np.testing.assert_allclose(found.motion[0, :, 0], expected, rtol=1e-5, atol=1e-5)
    assert met == 1
    assert error == pytest.approx((np.abs(Polynomial.polyval(d, expected) - path) * fade).max(), rel=1e-4)


def test_motions_that_are_cubics_keep_their_bits() -> None:
    given = one_of_the_fifth_order(0.0)
    found, _, _ = as_cubics(given)
    assert found.motion.shape[1:] == (4, 3)
    np.testing.assert_array_equal(found.motion[1:], given.motion[1:, :4])
    all_cubics, met, error = as_cubics(dynamics())
    np.testing.assert_array_equal(all_cubics.motion, dynamics().motion)
    assert (met, error) == (0, 0.0)
