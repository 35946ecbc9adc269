"""The difference of colours, which plane sweeps and scene flow compute many thousand times per picture."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["colour_difference"]


def colour_difference(
    first: npt.NDArray[np.int16],  # [N, C] levels of 255
    second: npt.NDArray[np.int16],  # [N, C]
) -> npt.NDArray[np.float32]:
    """Return [N] the mean over C values of by how much colours differ, levels of 255.

    The sums are whole numbers and exact. They are a matrix product, as numpy's mean over an axis of a few numbers takes
    several times as long as reading them does.
    """
    apart = first - second
    np.abs(apart, out=apart)
    count = apart.shape[1]
    return np.asarray(apart.astype(np.float32) @ np.ones(count, np.float32) / np.float32(count))
