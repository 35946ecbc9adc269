"""Lens models against OpenCV's formulas worked out by hand; test_colmap_lens.py compares all of them with COLMAP."""

from __future__ import annotations

import math

import numpy as np
import pytest

from hgs_core.capture.lenses.lens import PINHOLE, Division, FieldOfView, Polynomial, Unified, opencv_lens

X, Y = np.array([0.5]), np.array([-0.25])
R2 = 0.3125


def test_opencv_s_coefficients_are_taken_in_its_order() -> None:
    """Independent reference: the formula of OpenCV's calib3d documentation for one ray."""
    x, y = opencv_lens([0.1, -0.2, 0.01, 0.02, 0.3, 0.04, 0.05, 0.06, 0.001, 0.002, 0.003, 0.004], False).apply(X, Y)
    d = (1 + 0.1 * R2 - 0.2 * R2**2 + 0.3 * R2**3) / (1 + 0.04 * R2 + 0.05 * R2**2 + 0.06 * R2**3)
    assert x[0] == pytest.approx(0.5 * d + 2 * 0.01 * -0.125 + 0.02 * (R2 + 2 * 0.25) + 0.001 * R2 + 0.002 * R2**2)
    assert y[0] == pytest.approx(-0.25 * d + 0.01 * (R2 + 2 * 0.0625) + 2 * 0.02 * -0.125 + 0.003 * R2 + 0.004 * R2**2)


def test_opencv_s_fisheye_bends_angles() -> None:
    x, y = opencv_lens([0.1, -0.2, 0.03, 0.004], True).apply(X, Y)
    angle = math.atan(math.sqrt(R2))
    bent = angle * (1 + 0.1 * angle**2 - 0.2 * angle**4 + 0.03 * angle**6 + 0.004 * angle**8)
    assert math.hypot(x[0], y[0]) == pytest.approx(bent)
    assert y[0] / x[0] == pytest.approx(-0.5)


def test_zeros_at_the_end_of_a_list_do_not_count() -> None:
    assert opencv_lens([0.0] * 14, False) == PINHOLE
    assert opencv_lens([0.1, 0.0, 0.0, 0.0, 0.0], True) == Polynomial(radial=(0.1,), fisheye=True)
    assert opencv_lens([], False) == PINHOLE


@pytest.mark.parametrize(("count", "fisheye", "problem"), [(14, False, "tilted"), (5, True, "5 coefficients of a")])
def test_lists_that_no_model_has_are_refused(count: int, fisheye: bool, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        opencv_lens([0.1] * count, fisheye)


@pytest.mark.parametrize(
    "lens", [Polynomial((0.1,), fisheye=True), FieldOfView(0.9), FieldOfView(0.0), Division(-0.1), Unified(0.6, 1.1)]
)
def test_the_axis_stays_where_it_is(lens: Polynomial | FieldOfView | Division | Unified) -> None:
    assert [float(v[0]) for v in lens.apply(np.zeros(1), np.zeros(1))] == [0.0, 0.0]


def test_numbers_of_single_precision_stay_so() -> None:
    x = np.linspace(-0.5, 0.5, 5, dtype=np.float32)
    for lens in (opencv_lens([0.1, 0.2, 0.01], False), opencv_lens([0.1], True), FieldOfView(0.9), Unified(0.6, 1.1)):
        assert {part.dtype for part in lens.apply(x, x)} == {np.dtype(np.float32)}
