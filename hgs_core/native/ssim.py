"""Structural similarity on numpy arrays."""

from __future__ import annotations

import ctypes

from hgs_core.base.cores import core_count
from hgs_core.native.kernel_arrays import Floats, address, planes_size
from hgs_core.native.library import check, load

__all__ = ["mean_ssim"]


def mean_ssim(image: Floats, target: Floats, *, threads: int | None = None) -> float:
    """Return the mean over pixels and channels of the structural similarity of two pictures.

    Args:
        image: [3, H, W] planes, data range 1, contiguous.
        target: [3, H, W].
        threads: default `core_count()`.

    Raises:
        ValueError: an array of another shape or type.
        RuntimeError: no compiled library.
    """
    height, width = planes_size(image)
    mean = ctypes.c_double()
    status = load().hgs_ssim(
        ctypes.c_void_p(address("image", image, image.shape)),
        ctypes.c_void_p(address("target", target, image.shape)),
        width,
        height,
        threads or core_count(),
        ctypes.byref(mean),
    )
    check(status)
    return mean.value
