"""Pairs of pictures that any implementation can make again, for scores quoted from other programs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["wave_pair"]


def wave_pair(height: int, width: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return two pictures [3, H, W] in [0, 1]: waves, and the same waves shifted, flattened and with a fine pattern."""
    c, y, x = np.meshgrid(np.arange(3), np.arange(height), np.arange(width), indexing="ij")

    def waves(shift: float) -> npt.NDArray[np.float64]:
        return 0.5 + 0.25 * np.sin(0.07 * x + 0.5 * c + shift) + 0.2 * np.cos(0.11 * y - 0.03 * x * (c + 1))

    return waves(0.0), 0.05 + 0.85 * waves(0.3) + 0.05 * np.sin(1.7 * x + 2.3 * y + c)
