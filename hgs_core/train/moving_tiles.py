"""The part of a picture that moves, in the rasterizer's tiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from hgs_core.base.arrays import Mask
from hgs_core.render.constants import TILE
from hgs_core.render.tiles import pixels_to_tiles, tiles_to_pixels
from hgs_core.render.types import Window
from hgs_core.scene.camera import Camera
from hgs_core.train.colour_correction import CameraColours
from hgs_core.train.loss import photometric_loss

__all__ = ["MovingTiles", "loss_gradient", "tiles_of"]


@dataclass(frozen=True)
class MovingTiles:
    """The tiles in which something moves, and the smallest window of whole tiles around them."""

    tiles: Mask  # [ceil(H/16), ceil(W/16)]
    window: Window  # pixels

    def cut(self, picture: Tensor) -> Tensor:
        """Return the window of a picture [3, H, W]."""
        return picture[:, self.window[0], self.window[1]]

    def drawn(self) -> Tensor:
        """Return which pixels of the window lie in one of the tiles."""
        rows, columns = self.window
        return torch.from_numpy(tiles_to_pixels(self.tiles, columns.stop, rows.stop)[self.window])


def tiles_of(moving: Mask) -> MovingTiles | None:
    """Return the tiles of the pixels [H, W] that move; None if none does."""
    height, width = moving.shape
    tiles = pixels_to_tiles(moving)
    if not tiles.any():
        return None
    down, across = np.flatnonzero(tiles.any(1)), np.flatnonzero(tiles.any(0))
    rows = slice(int(down[0]) * TILE, min(height, (int(down[-1]) + 1) * TILE))
    columns = slice(int(across[0]) * TILE, min(width, (int(across[-1]) + 1) * TILE))
    return MovingTiles(tiles, (rows, columns))


def loss_gradient(
    picture: Tensor,
    target: Tensor,
    camera: Camera,
    moving: MovingTiles,
    dssim: float,
    colours: CameraColours | None = None,
) -> Tensor:
    """Return the gradient [3, H, W] of the loss of a picture of which the moving tiles alone were drawn.

    It is that of the whole picture's loss, in which all other pixels count as perfect, but that SSIM's windows stand
    where they do in a picture of the window's size.

    Args:
        picture: [3, H, W] as the scene shows it.
        target: [3, h, w], the window of it.
        camera: at the size of the picture.
        moving: which tiles were drawn.
        dssim: lambda of the loss.
        colours: the camera's, or None: as the scene shows them.
    """
    drawn = moving.drawn().to(picture.device)
    window = moving.cut(picture).clone().requires_grad_(True)
    shown = window if colours is None else colours.shown(window, camera, moving.window)
    loss = photometric_loss(torch.where(drawn, shown, target), target, dssim)
    (gradient,) = torch.autograd.grad(loss, window)
    whole = torch.zeros_like(picture)
    moving.cut(whole).copy_(gradient.mul_(target[0].numel() / picture[0].numel()))
    return whole
