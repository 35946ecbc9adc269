"""Bilinear resampling of pictures on numpy arrays."""

from __future__ import annotations

import ctypes

import numpy as np
import numpy.typing as npt

from hgs_core.native.kernel_arrays import address
from hgs_core.native.library import check, load

__all__ = ["resampled"]


def resampled(
    picture: npt.NDArray[np.uint8],
    corners: npt.NDArray[np.int32],
    right: npt.NDArray[np.float32],
    lower: npt.NDArray[np.float32],
) -> npt.NDArray[np.uint8]:
    """Return the colours of a picture at N places, [N, C], rounded: blends of four pixels, in one thread.

    Args:
        picture: [H, W, C], C is 1 or 3.
        corners: [N] the number of the upper left one of the four, which has a neighbour to the right and below.
        right: [N] the share of the right ones, 0 to 1.
        lower: [N] the share of the lower ones, 0 to 1.

    Raises:
        ValueError: an array of another shape or type, or a corner outside of the picture.
        RuntimeError: no compiled library.
    """
    height, width, channels = picture.shape
    if channels not in (1, 3):
        raise ValueError(f"picture must have 1 or 3 channels, not {channels}")
    count = len(corners)
    if count and not (corners.min() >= 0 and corners.max() < width * (height - 1) - 1):
        raise ValueError("corners must lie inside of the picture")
    result = np.empty((count, channels), np.uint8)
    status = load().hgs_resample(
        ctypes.c_void_p(address("picture", picture, picture.shape, np.uint8)),
        width,
        channels,
        ctypes.c_void_p(address("corners", corners, (count,), np.int32)),
        ctypes.c_void_p(address("right", right, (count,))),
        ctypes.c_void_p(address("lower", lower, (count,))),
        ctypes.c_int64(count),
        ctypes.c_void_p(result.ctypes.data),
    )
    check(status)
    return result
