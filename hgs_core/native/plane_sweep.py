"""The plane sweep on numpy arrays: at which of many depths every pixel agrees best with other pictures."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hgs_core.native.kernel_arrays import Floats, address
from hgs_core.native.library import check, load
from hgs_core.scene.camera import Camera

__all__ = ["plane_sweep"]

_LEAST_DEPTHS = 3


class _Source(ctypes.Structure):
    _fields_ = (
        ("grey", ctypes.c_void_p),
        ("width", ctypes.c_int32),
        ("height", ctypes.c_int32),
        ("map", ctypes.c_double * 12),
    )


def plane_sweep(
    camera: Camera,
    grey: Floats,
    sources: Sequence[tuple[Camera, Floats]],
    depths: npt.NDArray[np.float64],
) -> tuple[Floats, Floats]:
    """Return for every pixel which of the depths fits best, and how badly it fits.

    Windows of 9x9 pixels are compared by their normalised correlation, with the three sources that fit best at each
    depth (Collins, CVPR 1996). Semi-global matching (Hirschmueller, TPAMI 2008) then weighs that against smoothness.

    Args:
        camera: of the picture that is swept.
        grey: [H, W] its brightness, 0 to 1.
        sources: other cameras and their pictures [H', W'], two pixels wide and high at least.
        depths: [D] at least three, in order, evenly in what they move on the screen.

    Returns:
        Places [H, W] among the depths, from 0 to D - 1 and between two where that fits better, and costs [H, W]: 0
        where windows are alike, 0.5 where they are unlike or blank, 0.9 where no source sees the point.

    Raises:
        ValueError: an array of another shape or type, or too few depths.
        RuntimeError: no compiled library.
    """
    if len(depths) < _LEAST_DEPTHS:
        raise ValueError(f"a sweep needs {_LEAST_DEPTHS} depths or more, got {len(depths)}")
    shape = (camera.height, camera.width)
    places, costs = np.empty(shape, np.float32), np.empty(shape, np.float32)
    seen = (_Source * len(sources))(*(_source(camera, other, picture) for other, picture in sources))
    status = load().hgs_plane_sweep(
        ctypes.c_void_p(address("grey", grey, shape)),
        camera.width,
        camera.height,
        seen,
        len(sources),
        ctypes.c_void_p(address("depths", depths, (len(depths),), np.float64)),
        len(depths),
        ctypes.c_void_p(address("places", places, shape)),
        ctypes.c_void_p(address("costs", costs, shape)),
    )
    check(status)
    return places, costs


def _source(camera: Camera, other: Camera, picture: Floats) -> _Source:
    at = address("picture", picture, (other.height, other.width))
    if min(other.width, other.height) < 2:
        raise ValueError(f"a source must be two pixels wide and high at least, got {other.width}x{other.height}")
    turn = other.world_to_camera[:3, :3] @ camera.world_to_camera[:3, :3].T
    shift = other.world_to_camera[:3, 3] - turn @ camera.world_to_camera[:3, 3]
    pixels = np.column_stack(
        (_intrinsics(other) @ turn @ np.linalg.inv(_intrinsics(camera)), _intrinsics(other) @ shift)
    )
    return _Source(at, other.width, other.height, (ctypes.c_double * 12)(*pixels.ravel()))


def _intrinsics(camera: Camera) -> npt.NDArray[np.float64]:
    return np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]], np.float64)
