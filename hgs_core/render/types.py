"""What rendering returns and what it counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from torch import Tensor

__all__ = ["Render", "ScreenStatistics"]


class Render(NamedTuple):
    """One rendered picture."""

    rgb: Tensor  # [3, H, W] display-referred sRGB, background included; not clamped
    alpha: Tensor  # [H, W] 1 - transmittance, in [0, 1]


@dataclass(frozen=True)
class ScreenStatistics:
    """What density control needs to know about every splat, accumulated in place over backward passes.

    One entry per splat, statics first, then dynamics. A pass counts a splat when it is in the gradient set and its
    visible extent overlaps the picture.
    """

    grad_norm_sum: npt.NDArray[np.float32]  # [N] sum over passes of |dL / d mean2d|, the mean in pixels
    count: npt.NDArray[np.int32]  # [N] passes that saw the splat
    max_radius: npt.NDArray[np.float32]  # [N] largest 3 sigma radius (major axis) seen, pixels

    @staticmethod
    def zeros(n: int) -> ScreenStatistics:
        """Return statistics of `n` splats that no pass has seen."""
        return ScreenStatistics(np.zeros(n, np.float32), np.zeros(n, np.int32), np.zeros(n, np.float32))

    def rows(self, selection: slice) -> ScreenStatistics:
        """Return the statistics of some splats, as views."""
        return ScreenStatistics(self.grad_norm_sum[selection], self.count[selection], self.max_radius[selection])
