"""Colour maps and falloffs of cameras on numpy arrays."""

from __future__ import annotations

import ctypes
from typing import NamedTuple

import numpy as np

from hgs_core.base.cores import core_count
from hgs_core.native.kernel_arrays import Floats, address, planes_size
from hgs_core.native.library import check, load

__all__ = ["ColourGradients", "LensAxis", "camera_shown", "camera_shown_backward"]


class LensAxis(NamedTuple):
    """The centre of a lens falloff and the unit of its radius; all in pixels."""

    x: float  # pixels right of the picture's left edge; outside for a part of the camera's picture
    y: float
    half_diagonal: float  # half diagonal of the camera's whole picture


class ColourGradients(NamedTuple):
    """Gradients of a loss on the result of `camera_shown`, towards its arguments."""

    picture: Floats  # [3, H, W]
    affine: Floats  # [3, 4]
    falloff: Floats  # [2]


class _CCameraColours(ctypes.Structure):
    """The colours as a camera shows them."""

    _fields_ = (
        ("affine", ctypes.c_float * 12),
        ("falloff", ctypes.c_float * 2),
        ("cx", ctypes.c_double),
        ("cy", ctypes.c_double),
        ("half_diagonal", ctypes.c_double),
    )


def camera_shown(
    picture: Floats, affine: Floats, falloff: Floats, lens: LensAxis, *, threads: int | None = None
) -> Floats:
    """Return `A (gain rgb) + b` of every pixel, with the falloff of the lens as gain (`render/camera_colours.py`).

    Args:
        picture: [3, H, W] planes, contiguous.
        affine: [3, 4] float32, `[A | b]`.
        falloff: [2] float32, coefficients of the gain.
        lens: where it looks.
        threads: default `core_count()`.

    Raises:
        ValueError: an array of another shape or type.
        RuntimeError: no compiled library.
    """
    height, width = planes_size(picture)
    shown = np.empty_like(picture)
    status = load().hgs_camera_shown(
        ctypes.byref(_struct(affine, falloff, lens)),
        ctypes.c_void_p(address("picture", picture, picture.shape)),
        width,
        height,
        threads or core_count(),
        ctypes.c_void_p(address("shown", shown, picture.shape)),
    )
    check(status)
    return shown


def camera_shown_backward(
    gradient: Floats, picture: Floats, affine: Floats, falloff: Floats, lens: LensAxis, *, threads: int | None = None
) -> ColourGradients:
    """Return the gradients of a loss; `gradient` is the one towards the result of `camera_shown`.

    Args:
        gradient: [3, H, W] planes, contiguous.
        picture: as `camera_shown` was given it, and all that follow.
        affine: [3, 4].
        falloff: [2].
        lens: where it looks.
        threads: default `core_count()`.

    Raises:
        ValueError: an array of another shape or type.
        RuntimeError: no compiled library.
    """
    height, width = planes_size(picture)
    found = ColourGradients(np.empty_like(picture), np.empty((3, 4), np.float32), np.empty(2, np.float32))
    status = load().hgs_camera_shown_backward(
        ctypes.byref(_struct(affine, falloff, lens)),
        ctypes.c_void_p(address("picture", picture, picture.shape)),
        ctypes.c_void_p(address("gradient", gradient, picture.shape)),
        width,
        height,
        threads or core_count(),
        *(ctypes.c_void_p(address(name, array, array.shape)) for name, array in found._asdict().items()),
    )
    check(status)
    return found


def _struct(affine: Floats, falloff: Floats, lens: LensAxis) -> _CCameraColours:
    address("affine", affine, (3, 4))
    address("falloff", falloff, (2,))
    return _CCameraColours((ctypes.c_float * 12)(*affine.ravel()), (ctypes.c_float * 2)(*falloff), *lens)
