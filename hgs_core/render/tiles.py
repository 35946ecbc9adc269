"""Which tiles of a picture something dynamic touches."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.render.constants import TILE
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats

__all__ = ["pixels_to_tiles", "tiles_of_dynamic", "tiles_to_pixels"]


def tiles_of_dynamic(
    dynamic: DynamicSplats[Tensor], camera: Camera, time: float, *, backend: str = "auto", antialiased: bool = False
) -> npt.NDArray[np.bool_]:
    """Return the tiles [ceil(H/16), ceil(W/16)] in which a dynamic splat colours a pixel at normalised `time`.

    No other tile can pass a gradient to a dynamic splat, so a dynamic training step need not draw it. Raises what
    `rasterize` raises.
    """
    alone = rasterize(None, dynamic, camera, time, backend=backend, gradients="none", antialiased=antialiased)
    return pixels_to_tiles((alone.alpha > 0).cpu().numpy())


def pixels_to_tiles(pixels: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the tiles [ceil(H/16), ceil(W/16)] with at least one of the pixels [H, W]."""
    height, width = pixels.shape
    rows, columns = -(-height // TILE), -(-width // TILE)
    padded = np.zeros((rows * TILE, columns * TILE), np.bool_)
    padded[:height, :width] = pixels
    return np.asarray(padded.reshape(rows, TILE, columns, TILE).any((1, 3)), np.bool_)


def tiles_to_pixels(tiles: npt.NDArray[np.bool_], width: int, height: int) -> npt.NDArray[np.bool_]:
    """Return the mask of pixels [H, W] that the tiles cover."""
    return tiles.repeat(TILE, 0).repeat(TILE, 1)[:height, :width]
