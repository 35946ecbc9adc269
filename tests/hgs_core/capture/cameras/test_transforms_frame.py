"""A frame of transforms.json as a camera. test_transforms.py reads whole files."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.transforms_frame import camera_of_frame, number_of
from hgs_core.capture.lenses.lens import PINHOLE, Lens, Polynomial

FRAME: dict[str, Any] = {"fl_x": 50.0, "w": 64, "h": 48, "transform_matrix": np.eye(4).tolist()}


def test_without_centre_and_second_focal_length_pixels_are_square() -> None:
    camera = camera_of_frame(FRAME, None, "x")
    assert (camera.focal, camera.centre, camera.size, camera.lens) == ((50, 50), None, (64, 48), PINHOLE)


def test_angles_of_view_are_of_the_stated_size_or_the_picture_s() -> None:
    angle = {"camera_angle_x": 2 * math.atan(32 / 45), "transform_matrix": FRAME["transform_matrix"]}
    assert camera_of_frame(angle | {"w": 64, "h": 48}, (128, 96), "x").focal == pytest.approx((45, 45))
    assert camera_of_frame(angle, (128, 96), "x").focal == pytest.approx((90, 90))


def test_opengl_s_axes_point_up_and_backwards() -> None:
    np.testing.assert_array_equal(camera_of_frame(FRAME, None, "x").world_to_camera, np.diag([1, -1, -1, 1]))


@pytest.mark.parametrize(
    ("fields", "lens"),
    [
        ({"k1": 0.1, "p2": 0.02}, Polynomial(radial=(0.1, 0, 0, 0), tangential=(0, 0.02))),
        ({"camera_model": "OPENCV_FISHEYE", "k1": 0.1}, Polynomial(radial=(0.1, 0, 0, 0), fisheye=True)),
        ({"is_fisheye": True}, Polynomial(radial=(0, 0, 0, 0), fisheye=True)),
        ({"camera_model": "OPENCV"}, PINHOLE),
    ],
)
def test_lenses(fields: dict[str, Any], lens: Lens) -> None:
    assert camera_of_frame(FRAME | fields, None, "x").lens == lens


def test_an_unknown_lens_lists_those_that_are_known() -> None:
    with pytest.raises(InputError, match=r"camera_model is ORTHOPHOTO; .*OPENCV, OPENCV_FISHEYE"):
        camera_of_frame(FRAME | {"camera_model": "ORTHOPHOTO"}, None, "x")


@pytest.mark.parametrize("value", ["5", True, math.nan, None, [1]])
def test_a_number_is_a_number(value: object) -> None:
    with pytest.raises(InputError, match="x: k is"):
        number_of({"k": value}, "k", "x")
    assert number_of({}, "k", "x", 2.0) == 2.0
