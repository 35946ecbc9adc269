"""Arrays for the kernels: contiguous, float32, of the right shape."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["Floats", "address", "planes_size", "pointers"]

Floats = npt.NDArray[np.float32]


def address(name: str, array: npt.NDArray[Any], shape: tuple[int, ...], dtype: type = np.float32) -> int:
    """Return the address of the data of `array` after checking it for the kernels.

    Raises:
        ValueError: another shape or type, or not contiguous.
    """
    if array.shape != shape or array.dtype != dtype or not array.flags.c_contiguous:
        layout = "" if array.flags.c_contiguous else ", not contiguous"
        raise ValueError(
            f"{name} must be a contiguous {np.dtype(dtype).name} array of shape {shape}, "
            f"got {array.dtype.name} {array.shape}{layout}"
        )
    return int(array.ctypes.data)


def planes_size(image: Floats) -> tuple[int, int]:
    """Return the height and the width of planes [3, H, W].

    Raises:
        ValueError: another shape, or no pixel.
    """
    if image.ndim != 3 or image.shape[0] != 3 or 0 in image.shape:
        raise ValueError(f"image must be planes [3, H, W], got {image.shape}")
    _, height, width = image.shape
    return height, width


def pointers(names: Iterable[str]) -> list[tuple[str, Any]]:
    """Return the fields of a C struct that holds one pointer per name."""
    return [(name, ctypes.c_void_p) for name in names]
