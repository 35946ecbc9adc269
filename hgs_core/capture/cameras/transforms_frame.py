"""One frame of transforms.json as a camera: its pose with the axes of OpenGL, its intrinsics and its lens."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.cameras.rig import LARGEST, CalibratedCamera
from hgs_core.capture.lenses.lens import PINHOLE, Lens, Polynomial

__all__ = ["INTRINSICS", "camera_of_frame", "number_of"]

INTRINSICS = (
    *("fl_x", "fl_y", "camera_angle_x", "camera_angle_y", "cx", "cy", "w", "h"),
    *("k1", "k2", "k3", "k4", "p1", "p2", "camera_model", "is_fisheye"),
)
"""The fields that may hold for all frames of a file."""


_PERSPECTIVE = ("", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV")
_FISHEYE = ("OPENCV_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE")


def camera_of_frame(values: dict[str, Any], size: tuple[int, int] | None, where: str) -> CalibratedCamera:
    """Return the nameless camera of a frame; `size` (width, height) is its picture's, if known.

    `values` are those of the frame and, where it has none, of the file.

    Raises:
        InputError: values that are no camera, or an unknown kind of lens.
    """
    stated = None
    if "w" in values or "h" in values:
        stated = number_of(values, "w", where), number_of(values, "h", where)
    fx = _focal(values, "fl_x", "camera_angle_x", stated or size, 0, where)
    if fx is None:
        raise InputError(where, "neither fl_x nor camera_angle_x is given", "add the focal length in pixels")
    fy = _focal(values, "fl_y", "camera_angle_y" if "fl_x" not in values else "", stated or size, 1, where) or fx
    centre = None
    if "cx" in values or "cy" in values:
        centre = number_of(values, "cx", where), number_of(values, "cy", where)
    try:
        pose = np.array(values["transform_matrix"], np.float64)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        problem = f"transform_matrix is not a matrix of numbers ({shown(values.get('transform_matrix'))})"
        raise InputError(where, problem, "it is 4x4 numbers, camera-to-world") from error
    if pose.shape not in ((4, 4), (3, 4)) or not (np.abs(pose) < LARGEST).all():
        raise InputError(where, "transform_matrix is not a finite 4x4 matrix", "restore the poses")
    world_to_camera = np.eye(4)
    # Rows are the camera's axes in the world; OpenGL's y and z axes point the other way.
    world_to_camera[:3, :3] = pose[:3, :3].T * np.array([[1.0], [-1.0], [-1.0]])
    world_to_camera[:3, 3] = -world_to_camera[:3, :3] @ pose[:3, 3]
    return CalibratedCamera(where, (), world_to_camera, (fx, fy), centre, stated or size, _lens(values, where))


def _lens(values: dict[str, Any], where: str) -> Lens:
    kind = str(values.get("camera_model", ""))
    fisheye = kind in _FISHEYE or bool(values.get("is_fisheye"))
    if not fisheye and kind not in _PERSPECTIVE:
        cure = f"undistort the pictures to pinhole cameras first, or give {', '.join((*_PERSPECTIVE[1:], *_FISHEYE))}"
        raise InputError(where, f"camera_model is {shown(kind)[1:-1]}", cure)
    k = tuple(number_of(values, name, where, 0.0) for name in ("k1", "k2", "k3", "k4"))
    p1, p2 = (number_of(values, name, where, 0.0) for name in ("p1", "p2"))
    if fisheye:
        return Polynomial(radial=k, fisheye=True)
    return Polynomial(radial=k, tangential=(p1, p2)) if any((*k, p1, p2)) else PINHOLE


def _focal(
    values: dict[str, Any], name: str, angle_name: str, size: tuple[float, float] | None, axis: int, where: str
) -> float | None:
    """Return the focal length in pixels, given or from the angle of view in radians; 1 before the size is known."""
    if name in values:
        return number_of(values, name, where)
    if angle_name in values:
        angle = number_of(values, angle_name, where)
        if not 0 < angle < math.pi:
            raise InputError(where, f"{angle_name} is {angle:g}", "it is an angle of view in radians")
        return size[axis] / 2 / math.tan(angle / 2) if size else 1.0
    return None


def number_of(values: dict[str, Any], name: str, where: str, default: float | None = None) -> float:
    """Return a field that is a finite number.

    Raises:
        InputError: it is missing and has no default, or is something else.
    """
    value = values.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < LARGEST:
        raise InputError(where, f"{name} is {shown(value)}", "it is a number")
    return float(value)
