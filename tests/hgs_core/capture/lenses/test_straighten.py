"""Straight pictures against known ones, the border, and lenses that fold."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.lenses.lens import PINHOLE, Division, FieldOfView, Lens, Polynomial, Unified, opencv_lens
from hgs_core.capture.lenses.straighten import StraightView, ray_of
from hgs_core.scene.camera import Camera

PHOTO = Camera("photo", 200, 150, 160.0, 165.0, 104.0, 71.0, np.eye(4))
LENSES = [
    opencv_lens([-0.12, 0.03], False),  # barrel
    opencv_lens([0.15, -0.05, 0, 0, 0.01], False),  # pincushion
    opencv_lens([-0.05, 0, 0.004, -0.006], False),
    opencv_lens([-0.02, 0.001], True),
    Polynomial(fisheye=True),
    FieldOfView(0.9),
    Division(-0.15),
    Unified(0.6, 1.1),
]


def smooth(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A picture as a function of the ray: three slow waves, 0..255."""
    return np.stack((127 + 100 * np.sin(6 * x), 127 + 100 * np.cos(5 * y), 127 + 100 * np.sin(4 * (x + y))), axis=-1)


def points(camera: Camera) -> tuple[np.ndarray, np.ndarray]:
    """Every pixel's place on the sensor, in focal lengths."""
    column, row = np.meshgrid(np.arange(camera.width) + 0.5, np.arange(camera.height) + 0.5)
    return (column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy


def photograph(camera: Camera, lens: Lens) -> np.ndarray:
    u, v = points(camera)
    x, y, _ = ray_of(lens, u.ravel(), v.ravel())
    return smooth(x.reshape(u.shape), y.reshape(u.shape)).round().astype(np.uint8)


@pytest.mark.parametrize("lens", LENSES)
def test_a_ray_is_the_one_that_meets_the_sensor_there(lens: Lens) -> None:
    u, v = (values.ravel() for values in points(PHOTO))
    x, y, folded = ray_of(lens, u, v)
    assert not folded.any()
    there = lens.apply(x, y)
    np.testing.assert_allclose(there[0], u, atol=1e-9)
    np.testing.assert_allclose(there[1], v, atol=1e-9)


@pytest.mark.parametrize("lens", LENSES)
def test_a_straightened_picture_shows_what_a_pinhole_would(lens: Lens) -> None:
    view = StraightView.of(PHOTO, lens)
    picture = view.straightened(photograph(PHOTO, lens))
    assert picture.shape == (view.camera.height, view.camera.width, 3)
    assert np.abs(picture - smooth(*points(view.camera))).max() < 2.0  # rounding, and bends between pixels


@pytest.mark.parametrize("lens", LENSES)
def test_the_straight_picture_lies_inside_the_photograph_and_fills_it(lens: Lens) -> None:
    straight = StraightView.of(PHOTO, lens).camera
    x, y = lens.apply(*points(straight))
    column, row = x * PHOTO.fx + PHOTO.cx, y * PHOTO.fy + PHOTO.cy
    for values, last in ((column, PHOTO.width - 0.5), (row, PHOTO.height - 0.5)):
        assert values.min() > 0.5 - 0.05
        assert values.max() < last + 0.05
        assert values.min() < 2.5
        assert values.max() > last - 2.5
    assert (straight.fx, straight.fy) == (PHOTO.fx, PHOTO.fy)


def test_no_distortion_changes_nothing() -> None:
    picture = np.random.default_rng(0).integers(0, 255, (150, 200, 3)).astype(np.uint8)
    view = StraightView.of(PHOTO, PINHOLE)
    assert view.camera is PHOTO
    assert view.straightened(picture) is picture


def test_hardly_any_distortion_loses_no_pixel() -> None:
    straight = StraightView.of(PHOTO, opencv_lens([1e-9], False)).camera
    assert abs(straight.width - PHOTO.width) <= 1
    assert straight.cx == pytest.approx(PHOTO.cx, abs=1e-4)


def test_coefficients_that_fold_the_picture_are_refused() -> None:
    wide = dataclasses.replace(PHOTO, fx=60.0, fy=60.0)
    with pytest.raises(InputError, match=r"camera photo.*fold the picture"):
        StraightView.of(wide, opencv_lens([-0.5], False))


def test_a_wide_fisheye_is_cut_at_60_degrees() -> None:
    wide = dataclasses.replace(PHOTO, fx=70.0, fy=70.0, cx=100.0, cy=75.0)  # 82 degrees to the left and right
    view = StraightView.of(wide, Polynomial(fisheye=True))
    straight = view.camera
    assert view.cut
    assert np.degrees(np.arctan(straight.cx / straight.fx)) == pytest.approx(60, abs=0.5)
    assert straight.width * straight.height <= 2.1 * wide.width * wide.height
    picture = view.straightened(photograph(wide, view.lens))
    assert np.abs(picture - smooth(*points(straight)))[20:-20, 20:-20].mean() < 3


def test_a_mask_is_straightened_like_its_picture() -> None:
    view = StraightView.of(PHOTO, LENSES[0])
    bright = photograph(PHOTO, view.lens)[..., 0] > 127
    expected = smooth(*points(view.camera))[..., 0] > 127
    assert (view.straight_mask(bright) != expected).mean() < 0.01
