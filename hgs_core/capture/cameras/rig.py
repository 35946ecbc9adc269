"""The rig that every reader of cameras returns: cameras as their file describes them, apart from any pictures."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.lenses.lens import PINHOLE, Lens
from hgs_core.scene.camera import Camera

__all__ = [
    "LARGEST",
    "MOST_CAMERAS",
    "CalibratedCamera",
    "CameraFormat",
    "Rig",
    "finite",
    "lens_numbers",
    "pose_of",
    "rotation_matrix",
]

MOST_CAMERAS = 100_000
"""Of a calibration; poses of every picture of a long capture are as many."""

LARGEST = 1e30
"""Of a number in a calibration: products of more may overflow."""

_LARGEST_RATIO = 1e5  # focal length over picture width, and its inverse
_MOST_COEFFICIENTS = 14  # coefficients of a lens
_ROUNDING = 2.0  # pixels by which a scaled picture's side may differ: encoders round to whole and even ones


@dataclass(frozen=True)
class CalibratedCamera:
    """One camera of a calibration."""

    where: str  # the file and the place in it, for people
    names: tuple[str, ...]  # possible names of its pictures, the likeliest first; none: pictures by order
    world_to_camera: npt.NDArray[np.float64]  # [4, 4], OpenCV: x right, y down, z forward
    focal: tuple[float, float]  # pixels, across and down
    centre: tuple[float, float] | None = None  # pixels, centres of pixels at +0.5; None: the middle of the picture
    size: tuple[float, float] | None = None  # width, height of the calibrated pictures; None: the footage's size
    lens: Lens = PINHOLE
    pictures: tuple[Path, ...] = ()  # named by the file itself: one video, or one picture for each frame
    stamps: tuple[float, ...] = ()  # frame numbers or seconds of these pictures, if the file has them

    def fits(self, width: int, height: int) -> bool:
        """Return whether pictures of `width` by `height` pixels may be the calibrated ones, scaled."""
        across, down = self.size or (width, height)
        if not (across > 0 and down > 0):
            return False
        return abs(down * width / across - height) <= _ROUNDING or abs(across * height / down - width) <= _ROUNDING

    def camera(self, name: str, width: int, height: int) -> Camera:
        """Return the camera of pictures of `width` by `height` pixels, to which the calibrated ones were scaled.

        Raises:
            InputError: values that are no camera, or another shape of picture.
        """
        calibrated = self.size or (width, height)
        if not (calibrated[0] > 0 and calibrated[1] > 0):
            problem = f"width and height are {calibrated[0]:g} and {calibrated[1]:g}"
            raise InputError(self.where, problem, "they are the sides of the picture in pixels")
        sx, sy = width / calibrated[0], height / calibrated[1]
        if not self.fits(width, height):
            raise InputError(self.where, *_other_shape(calibrated, (width, height)))
        for focal in self.focal:
            if focal > 0 and not 1 / _LARGEST_RATIO < focal / calibrated[0] < _LARGEST_RATIO:
                problem = f"the focal length is {focal:g} pixels, and the picture has {calibrated[0]:g}"
                raise InputError(self.where, problem, "calibrate again: no lens sees so")
        centre = self.centre or (calibrated[0] / 2, calibrated[1] / 2)
        try:
            return Camera(
                name,
                width,
                height,
                self.focal[0] * sx,
                self.focal[1] * sy,
                centre[0] * sx,
                centre[1] * sy,
                self.world_to_camera,
            )
        except InputError as error:
            raise InputError(
                self.where, error.problem, error.cure or "calibrate again, or correct the number"
            ) from error


@dataclass(frozen=True)
class Rig:
    """All cameras of a capture."""

    files: tuple[Path, ...]  # all sources; their content is part of the fingerprint
    cameras: Sequence[CalibratedCamera]
    rate: float | None = None  # frames per second of pictures in folders, where the format has one
    notes: tuple[str, ...] = ()  # omissions, for people
    stamps_in_seconds: bool = False  # whether the cameras' stamps are seconds
    mirrored: bool = False  # whether all poses were reflections, and x of the world was turned

    def digest(self) -> str:
        """Return the SHA-256 of the sources' content."""
        digest = hashlib.sha256()
        for file in self.files:
            digest.update(file.read_bytes())
        return digest.hexdigest()


@dataclass(frozen=True)
class CameraFormat:
    """A way in which calibrations are written."""

    name: str  # shown to people
    files: str  # usual file names, shown to people
    find: Callable[[Path], Path | None]  # the file in the folder of a capture
    read: Callable[[Path, Path], Rig]  # capture folder, file -> rig


def _other_shape(calibrated: tuple[float, float], size: tuple[int, int]) -> tuple[str, str]:
    problem = f"the camera is for {calibrated[0]:g}x{calibrated[1]:g} pixels and the pictures have {size[0]}x{size[1]}"
    on_its_side = abs(size[0] * calibrated[0] / (size[1] * calibrated[1]) - 1.0) <= 0.02
    if on_its_side:
        return problem, "calibrate with pictures as players show them, upright"
    return problem, "scale pictures without cropping them, or calibrate with pictures as they are"


def rotation_matrix(values: Any, where: str) -> npt.NDArray[np.float64]:
    """Return the rotation [3, 3] of a matrix, or of a vector along its axis as long as its angle in radians.

    Raises:
        InputError: the values are neither.
    """
    cure = "it is a 3x3 matrix, or 3 numbers, the axis times the angle in radians"
    try:
        found = np.array(values, np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(where, f"the rotation is {shown(values)}", cure) from error
    if found.size not in (3, 9) or not (np.abs(found) < LARGEST).all():  # NaN is less than nothing
        raise InputError(where, f"the rotation is {shown(found.tolist())}", cure)
    if found.size == 9:
        return found.reshape(3, 3)
    x, y, z = found.reshape(3)
    angle = math.sqrt(x * x + y * y + z * z)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    first, second = (math.sin(angle) / angle, (1 - math.cos(angle)) / angle**2) if angle > 1e-9 else (1.0, 0.5)
    return np.asarray(np.eye(3) + first * cross + second * (cross @ cross), np.float64)


def pose_of(rotation: npt.NDArray[np.float64], translation: Any, where: str) -> npt.NDArray[np.float64]:
    """Return the matrix [4, 4] of a rotation [3, 3] and a translation of 3 numbers.

    Raises:
        InputError: the translation is not 3 finite numbers.
    """
    pose = np.eye(4)
    pose[:3, :3] = rotation
    pose[:3, 3] = finite(translation, 3, where, "the translation")
    return pose


def finite(values: Any, count: int, where: str, what: str) -> npt.NDArray[np.float64]:
    """Return `count` finite numbers from lists, however nested.

    Raises:
        InputError: they are not; the message says `what` they are.
    """
    try:
        found = np.array(values, np.float64).reshape(-1)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(where, f"{what} is {shown(values)}", f"it is {count} numbers") from error
    if len(found) != count or not (np.abs(found) < LARGEST).all():
        raise InputError(where, f"{what} is {shown(found.tolist())}", f"it is {count} finite numbers")
    return found


def lens_numbers(values: Any, where: str, what: str) -> list[float]:
    """Return the coefficients of a lens, a list that may be missing, empty or nested.

    Raises:
        InputError: there are more than any lens has, or something else than finite numbers.
    """
    if values is None or values is False or values == []:
        return []
    try:
        count = np.size(values)
    except (TypeError, ValueError) as error:
        raise InputError(where, f"{what} is {shown(values)}", "it is a list of numbers") from error
    if count > _MOST_COEFFICIENTS:
        raise InputError(where, f"{what} has {count} numbers", f"{_MOST_COEFFICIENTS} are the most that a lens has")
    return [float(value) for value in finite(values, count, where, what)]
