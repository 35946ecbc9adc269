"""The part of a picture that moves, in the rasterizer's tiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from hgs_core.base.arrays import Mask
from hgs_core.render.constants import TILE
from hgs_core.render.tiles import pixels_to_tiles, tiles_to_pixels
from hgs_core.train.colour_correction import CameraColours
from hgs_core.train.loss import photometric_loss

__all__ = ["MovingTiles", "loss_gradient", "tiles_of"]


@dataclass(frozen=True)
class MovingTiles:
    """The tiles in which something moves, and the smallest window of whole tiles around them."""

    tiles: Mask  # [ceil(H/16), ceil(W/16)]
    rows: slice  # of the window, pixels
    columns: slice

    def window(self, picture: Tensor) -> Tensor:
        """Return the window of a picture [3, H, W]."""
        return picture[:, self.rows, self.columns]

    def drawn(self) -> Tensor:
        """Return which pixels of the window lie in one of the tiles."""
        height, width = self.rows.stop, self.columns.stop
        return torch.from_numpy(tiles_to_pixels(self.tiles, width, height)[self.rows, self.columns])


def tiles_of(moving: Mask) -> MovingTiles | None:
    """Return the tiles of the pixels [H, W] that move; None if none does."""
    height, width = moving.shape
    tiles = pixels_to_tiles(moving)
    if not tiles.any():
        return None
    down, across = np.flatnonzero(tiles.any(1)), np.flatnonzero(tiles.any(0))
    return MovingTiles(
        tiles,
        slice(int(down[0]) * TILE, min(height, (int(down[-1]) + 1) * TILE)),
        slice(int(across[0]) * TILE, min(width, (int(across[-1]) + 1) * TILE)),
    )


def loss_gradient(
    picture: Tensor,
    target: Tensor,
    moving: MovingTiles,
    dssim: float,
    *,
    colours: CameraColours | None = None,
    gain: Tensor | None = None,
) -> Tensor:
    """Return the gradient [3, H, W] of the loss of a picture of which the moving tiles alone were drawn.

    It is that of the whole picture's loss, in which all other pixels count as perfect, but that SSIM's windows stand
    where they do in a picture of the window's size.

    Args:
        picture: [3, H, W] as the scene shows it.
        target: [3, H, W].
        moving: which tiles were drawn.
        dssim: lambda of the loss.
        colours: the camera's, or None: as the scene shows them.
        gain: [H, W] that of the camera's lens, `colours.gain`; None: its lens darkens nothing.
    """
    drawn, window, truth = moving.drawn().to(picture.device), moving.window(picture), moving.window(target)
    gain = None if gain is None else moving.window(gain[None])
    shown = window if colours is None else colours.shown_with(window, gain)
    compared = torch.where(drawn, shown, truth).requires_grad_(True)
    (gradient,) = torch.autograd.grad(photometric_loss(compared, truth, dssim), compared)
    gradient *= drawn * (truth[0].numel() / target[0].numel())
    if colours is not None:
        gradient = colours.pulled_back(gradient, gain)
    whole = torch.zeros_like(picture)
    moving.window(whole).copy_(gradient)
    return whole
