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
from hgs_core.train.loss import photometric_gradient

__all__ = ["MovingTiles", "loss_gradient", "tiles_of"]


@dataclass(frozen=True)
class MovingTiles:
    """The tiles in which something moves, the window of whole tiles around them, and the parts it falls into."""

    tiles: Mask  # [ceil(H/16), ceil(W/16)]
    window: Window  # pixels
    parts: tuple[Window, ...]  # windows of the picture, with still tiles between them; every moving tile is in one

    def cut(self, picture: Tensor) -> Tensor:
        """Return the window of a picture [3, H, W]."""
        return picture[:, self.window[0], self.window[1]]

    def within(self, part: Window) -> Window:
        """Return where a part lies in the window."""
        return _shifted(part[0], -self.window[0].start), _shifted(part[1], -self.window[1].start)

    def drawn(self, part: Window | None = None) -> Tensor:
        """Return which pixels of a part, or else of the window, lie in one of the tiles."""
        rows, columns = part or self.window
        tiles = self.tiles[rows.start // TILE : -(-rows.stop // TILE), columns.start // TILE : -(-columns.stop // TILE)]
        return torch.from_numpy(tiles_to_pixels(tiles, columns.stop - columns.start, rows.stop - rows.start))


def tiles_of(moving: Mask) -> MovingTiles | None:
    """Return the tiles of the pixels [H, W] that move; None if none does."""
    tiles = pixels_to_tiles(moving)
    if not tiles.any():
        return None

    def pixels(of_tiles: Window) -> Window:
        height, width = moving.shape
        rows, columns = of_tiles
        return (
            slice(rows.start * TILE, min(height, rows.stop * TILE)),
            slice(columns.start * TILE, min(width, columns.stop * TILE)),
        )

    down, across = (_runs(tiles, axis) for axis in (0, 1))
    around = slice(down[0].start, down[-1].stop), slice(across[0].start, across[-1].stop)
    return MovingTiles(tiles, pixels(around), tuple(pixels(part) for part in _parts(tiles)))


def _parts(tiles: Mask) -> list[Window]:
    """Cut tiles at rows and columns in which none is set, and the pieces again: the recursive X-Y cut of Nagy and Seth.

    People who stand apart leave much of the window around all of them still.
    """
    for axis in (0, 1):
        runs = _runs(tiles, axis)
        if len(runs) > 1 or runs[0] != slice(0, tiles.shape[axis]):
            cuts = [(run, slice(0, tiles.shape[1])) if axis == 0 else (slice(0, tiles.shape[0]), run) for run in runs]
            return [
                (_shifted(rows, cut[0].start), _shifted(columns, cut[1].start))
                for cut in cuts
                for rows, columns in _parts(tiles[cut])
            ]
    return [(slice(0, tiles.shape[0]), slice(0, tiles.shape[1]))]


def _runs(tiles: Mask, axis: int) -> list[slice]:
    """Return the runs of rows (axis 0) or columns (1) in which a tile is set."""
    borders = np.flatnonzero(np.diff(tiles.any(1 - axis), prepend=False, append=False)).tolist()
    return [slice(first, last) for first, last in zip(borders[::2], borders[1::2], strict=True)]


def _shifted(run: slice, by: int) -> slice:
    return slice(run.start + by, run.stop + by)


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
    where they do in pictures of the parts' sizes.

    Args:
        picture: [3, H, W] as the scene shows it.
        target: [3, h, w], the window of it.
        camera: at the size of the picture.
        moving: which tiles were drawn.
        dssim: lambda of the loss.
        colours: the camera's, or None: as the scene shows them.
    """
    whole = torch.zeros_like(picture)
    for part in moving.parts:
        (rows, columns), (down, across) = part, moving.within(part)
        wanted = target[:, down, across].contiguous()
        drawn = moving.drawn(part).to(picture.device)
        own = picture[:, rows, columns].contiguous()
        shown = own if colours is None else colours.shown(own, camera, part)
        gradient = photometric_gradient(torch.where(drawn, shown, wanted), wanted, dssim).mul_(drawn)
        if colours is not None:
            gradient = colours.pulled(gradient, own, camera, part)
        torch.mul(gradient, wanted[0].numel() / picture[0].numel(), out=whole[:, rows, columns])
    return whole
