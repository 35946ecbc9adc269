"""The coarse plane sweep on numpy arrays: points along rays compared with other pictures by colours alone."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.native.kernel_arrays import Floats, address
from hgs_core.native.library import check, load
from hgs_core.scene.camera import Camera

__all__ = ["VALUES", "colour_descriptors", "colour_sweep"]

VALUES = 6
"""Numbers of a descriptor: red, green and blue of the pixel's 3x3 window, and of its 7x7 window."""

Descriptors = npt.NDArray[np.uint8]
Doubles = npt.NDArray[np.float64]


class _View(ctypes.Structure):
    """A picture's descriptors, or a mask, and where points of the world fall in it."""

    _fields_ = (
        ("pixels", ctypes.c_void_p),
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("map", ctypes.c_double * 12),
    )


def colour_descriptors(picture: npt.NDArray[np.uint8]) -> Descriptors:
    """Return the descriptors of pixels, [H W, 6]: the means of their 3x3 and 7x7 windows, rounded down.

    Args:
        picture: [H, W, 3]; beyond it everything is black.

    Raises:
        ValueError: an array of another shape or type.
        RuntimeError: no compiled library.
    """
    height, width = picture.shape[:2]
    at = address("picture", picture, (height, width, 3), np.uint8)
    descriptors = np.empty((height * width, VALUES), np.uint8)
    check(load().hgs_colour_descriptors(ctypes.c_void_p(at), width, height, ctypes.c_void_p(descriptors.ctypes.data)))
    return descriptors


def colour_sweep(
    origin: Doubles,
    rays: Doubles,
    own: Descriptors,
    depths: Doubles,
    sources: Sequence[tuple[Camera, Descriptors]],
    hull: Sequence[tuple[Camera, npt.NDArray[np.bool_]]],
    *,
    hull_share: float,
    blind: float,
) -> Floats:
    """Return the costs of points along rays against other pictures, [R, D] levels of 255.

    Args:
        origin: [3] where the rays start.
        rays: [R, 3] what leads from there to depth 1.
        own: [R, 6] the descriptors that the points should have.
        depths: [D] that are tried.
        sources: cameras and the descriptors [H W, 6] of their pictures; the one that fits worst does not count, unless
            it is the only one.
        hull: cameras and masks [H, W]. Points of which fewer than the share `hull_share` of those that they fall in are
            set, or that fall in none, cost infinity; without any all points may be.
        hull_share: 0 to 1.
        blind: what counts for a source that a point falls outside of.

    Raises:
        ValueError: an array of another shape or type.
        RuntimeError: no compiled library.
    """
    count = len(rays)
    costs = np.empty((count, len(depths)), np.float32)
    compared = [
        _view(camera, address("descriptors", seen, (camera.height * camera.width, VALUES), np.uint8))
        for camera, seen in sources
    ]
    asked = [_view(camera, address("mask", mask, (camera.height, camera.width), np.bool_)) for camera, mask in hull]
    status = load().hgs_colour_sweep(
        _pointer("origin", origin, (3,), np.float64),
        _pointer("rays", rays, (count, 3), np.float64),
        _pointer("own", own, (count, VALUES), np.uint8),
        ctypes.c_int64(count),
        _pointer("depths", depths, (len(depths),), np.float64),
        len(depths),
        (_View * len(compared))(*compared),
        len(compared),
        (_View * len(asked))(*asked),
        len(asked),
        ctypes.c_double(hull_share),
        ctypes.c_float(blind),
        ctypes.c_void_p(costs.ctypes.data),
    )
    check(status)
    return costs


def _pointer(name: str, array: npt.NDArray[Any], shape: tuple[int, ...], dtype: type) -> ctypes.c_void_p:
    return ctypes.c_void_p(address(name, array, shape, dtype))


def _view(camera: Camera, pixels: int) -> _View:
    intrinsics = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    to_pixels = intrinsics @ camera.world_to_camera[:3]
    return _View(pixels, camera.width, camera.height, (ctypes.c_double * 12)(*to_pixels.ravel()))
