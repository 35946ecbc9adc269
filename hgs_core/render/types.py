"""The types of rendering: requests, results and counts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.render.constants import TILE
from hgs_core.scene.camera import Camera

__all__ = ["WHOLE", "Contributions", "Gradients", "Render", "ScreenStatistics", "View", "Window"]

Gradients = Literal["all", "static", "dynamic", "none"]

Window = tuple[slice, slice]
"""Rows and columns of a picture, from a first one to before a last one."""

WHOLE: Window = (slice(None), slice(None))


class Render(NamedTuple):
    """One rendered picture."""

    rgb: Tensor  # [3, H, W] display-referred sRGB, background included; not clamped
    alpha: Tensor  # [H, W] 1 - transmittance, in [0, 1]
    depth: Tensor | None = None  # [H, W] sum over splats of weight times z, world units; None unless asked for


class Contributions(NamedTuple):
    """The contribution of every splat to one picture: statics first, then dynamics; zero for splats that are not drawn.

    A splat's weight in a pixel is w = T alpha: the share of the pixel's colour that is the splat's.
    """

    total: npt.NDArray[np.float32]  # [N + M] sum over pixels of w, pixels
    peak: npt.NDArray[np.float32]  # [N + M] largest w of a pixel, in [0, 1)


@dataclass(frozen=True)
class ScreenStatistics:
    """The statistics of every splat for density control, accumulated in place over backward passes.

    One entry per splat, statics first, then dynamics. A pass counts a splat when it is in the gradient set and
    pixels pull at it: in the pictures where it is hidden none do, and a mean over those too would hide how wrong it is
    where it can be seen. A splat's pull is the norm over x and y of the sum over pixels of |dL / d mean2d|, the mean in
    pixels (AbsGS, Ye et al., 2024): in the gradient itself, pixels cancel that want the splat on opposite sides.
    """

    pull_sum: npt.NDArray[np.float32]  # [N] sum over passes of the pull, 1 / pixel
    count: npt.NDArray[np.int32]  # [N] passes in which a pixel pulled at the splat

    @staticmethod
    def zeros(n: int) -> ScreenStatistics:
        """Return statistics of `n` splats that no pass has seen."""
        return ScreenStatistics(np.zeros(n, np.float32), np.zeros(n, np.int32))

    def add(self, other: ScreenStatistics, rows: slice | npt.NDArray[np.int64]) -> None:
        """Add those of the splats `rows`, none of which is named twice, in place."""
        self.pull_sum[rows] += other.pull_sum
        self.count[rows] += other.count

    def rows(self, selection: slice) -> ScreenStatistics:
        """Return the statistics of some splats, as views."""
        return ScreenStatistics(self.pull_sum[selection], self.count[selection])


@dataclass(frozen=True)
class View:
    """Everything besides the splats that a picture depends on; `rasterize` describes the fields."""

    camera: Camera
    time: float = 0.0  # normalised
    background: tuple[float, float, float] = (0.0, 0.0, 0.0)
    tile_mask: npt.NDArray[np.bool_] | None = None  # [ceil(H/16), ceil(W/16)]
    antialiased: bool = False
    depth: bool = False
    gradients: Gradients = "all"
    statistics: ScreenStatistics | None = None
    rig: tuple[Camera, ...] = ()

    def __post_init__(self) -> None:
        """Refuse arguments that no backend can draw.

        Raises:
            InputError: a time that is not finite, a mask of another shape than the picture's tiles, or an unknown
                gradient set.
        """
        if not math.isfinite(self.time):
            raise InputError("time", f"{self.time} is not finite", "give a normalised time, usually in [0, 1]")
        tiles = (-(-self.camera.height // TILE), -(-self.camera.width // TILE))
        if self.tile_mask is not None and self.tile_mask.shape != tiles:
            raise InputError("tile_mask", f"shape {self.tile_mask.shape}", f"give one flag per tile, {tiles}")
        if self.gradients not in get_args(Gradients):
            raise InputError("gradients", f"unknown set {self.gradients!r}", f"use {', '.join(get_args(Gradients))}")
