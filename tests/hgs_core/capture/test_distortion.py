"""Lens distortion against its definition, a picture whose straight form is known, and the border."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.distortion import Distortion, straight_camera, straightened
from hgs_core.scene.camera import Camera

PHOTO = Camera("photo", 200, 150, 160.0, 165.0, 104.0, 71.0, np.eye(4))
LENSES = [
    Distortion(k1=-0.12, k2=0.03),  # barrel
    Distortion(k1=0.15, k2=-0.05, k3=0.01),  # pincushion
    Distortion(k1=-0.05, p1=0.004, p2=-0.006),
]


def smooth(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A picture as a function of the ray: three slow waves, 0..255."""
    return np.stack((127 + 100 * np.sin(6 * x), 127 + 100 * np.cos(5 * y), 127 + 100 * np.sin(4 * (x + y))), axis=-1)


def rays(camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    column, row = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    return (column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy


@pytest.mark.parametrize("lens", LENSES)
def test_removing_is_the_inverse_of_applying(lens: Distortion) -> None:
    x, y = rays(PHOTO)
    there = lens.apply(*lens.remove(x, y))
    np.testing.assert_allclose(there[0], x, atol=1e-9)
    np.testing.assert_allclose(there[1], y, atol=1e-9)


def test_the_polynomial_is_the_one_of_opencv() -> None:
    """Independent reference: the formula of OpenCV's calib3d documentation, worked out by hand for one ray."""
    x, y = Distortion(k1=0.1, k2=-0.2, p1=0.01, p2=0.02).apply(np.array([0.5]), np.array([-0.25]))
    r2 = 0.3125
    radial = 1 + 0.1 * r2 - 0.2 * r2**2
    assert x[0] == pytest.approx(0.5 * radial + 2 * 0.01 * -0.125 + 0.02 * (r2 + 0.5))
    assert y[0] == pytest.approx(-0.25 * radial + 0.01 * (r2 + 0.125) + 2 * 0.02 * -0.125)


@pytest.mark.parametrize("lens", LENSES)
def test_a_straightened_picture_shows_what_a_pinhole_would(lens: Distortion) -> None:
    photograph = smooth(*lens.remove(*rays(PHOTO))).round().astype(np.uint8)
    straight = straight_camera(PHOTO, lens)
    picture = straightened(photograph, PHOTO, lens, straight)
    assert picture.shape == (straight.height, straight.width, 3)
    assert np.abs(picture - smooth(*rays(straight))).max() < 2.0  # rounding, and bends between pixels


@pytest.mark.parametrize("lens", LENSES)
def test_the_straight_picture_lies_inside_the_photograph_and_fills_it(lens: Distortion) -> None:
    straight = straight_camera(PHOTO, lens)
    x, y = lens.apply(*rays(straight))
    column, row = x * PHOTO.fx + PHOTO.cx, y * PHOTO.fy + PHOTO.cy
    for values, last in ((column, PHOTO.width - 0.5), (row, PHOTO.height - 0.5)):
        assert values.min() > 0.5 - 0.05
        assert values.max() < last + 0.05
        assert values.min() < 2.5
        assert values.max() > last - 2.5
    assert (straight.fx, straight.fy) == (PHOTO.fx, PHOTO.fy)


def test_no_distortion_changes_nothing() -> None:
    picture = np.random.default_rng(0).integers(0, 255, (150, 200, 3)).astype(np.uint8)
    assert straight_camera(PHOTO, Distortion()) is PHOTO
    assert straightened(picture, PHOTO, Distortion(), PHOTO) is picture


def test_hardly_any_distortion_loses_no_pixel() -> None:
    straight = straight_camera(PHOTO, Distortion(k1=1e-9))
    assert abs(straight.width - PHOTO.width) <= 1
    assert straight.cx == pytest.approx(PHOTO.cx, abs=1e-4)


def test_coefficients_that_fold_the_picture_are_refused() -> None:
    wide = dataclasses.replace(PHOTO, fx=60.0, fy=60.0)
    with pytest.raises(InputError, match=r"camera photo.*fold the picture"):
        straight_camera(wide, Distortion(k1=-0.5))
