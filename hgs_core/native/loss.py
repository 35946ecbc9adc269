"""The training loss on numpy arrays."""

from __future__ import annotations

import ctypes

import numpy as np

from hgs_core.base.cores import core_count
from hgs_core.native.kernel_arrays import Floats, address, planes_size
from hgs_core.native.library import check, load

__all__ = ["l1_dssim"]


def l1_dssim(
    image: Floats, target: Floats, dssim_weight: float = 0.2, *, threads: int | None = None
) -> tuple[float, Floats]:
    """Compare two pictures by `(1 - w) mean |x - y| + w (1 - SSIM(x, y))` (docs/numerics.md, "Loss").

    SSIM is the mean over the windows around every second pixel of every third row.

    Args:
        image: [3, H, W] planes, data range 1, contiguous.
        target: [3, H, W].
        dssim_weight: w above.
        threads: default `core_count()`.

    Returns:
        The loss and its gradient with respect to `image`, [3, H, W].

    Raises:
        ValueError: an array of another shape or type.
        RuntimeError: no compiled library.
    """
    height, width = planes_size(image)
    gradient = np.empty_like(image)
    loss = ctypes.c_double()
    status = load().hgs_l1_dssim(
        ctypes.c_void_p(address("image", image, image.shape)),
        ctypes.c_void_p(address("target", target, image.shape)),
        width,
        height,
        ctypes.c_float(dssim_weight),
        threads or core_count(),
        ctypes.byref(loss),
        ctypes.c_void_p(address("gradient", gradient, image.shape)),
    )
    check(status)
    return loss.value, gradient
