"""Splats as single values, to tell which of them are the same to the bit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Floats
from hgs_core.scene.splats import StaticSplats

__all__ = ["rows_of"]


def rows_of(splats: StaticSplats[Floats]) -> NDArray[np.void]:
    """Return the numbers of each splat as one value [N]."""
    flat = [array if array.ndim == 2 else array[:, None] for _, array in splats.items()]
    rows = np.concatenate(flat, axis=1)
    rows = np.ascontiguousarray(rows, "<f4")
    return rows.view(np.dtype((np.void, rows.shape[1] * 4)))[:, 0]
