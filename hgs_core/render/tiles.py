"""Which tiles of a picture something dynamic touches."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.camera import Camera
from hgs_core.render.constants import TILE
from hgs_core.render.projection import project
from hgs_core.render.temporal import alive, moment_of_dynamic
from hgs_core.scene.splats import DynamicSplats

__all__ = ["tiles_of_dynamic", "tiles_to_pixels"]


def tiles_of_dynamic(dynamic: DynamicSplats[Tensor], camera: Camera, time: float) -> npt.NDArray[np.bool_]:
    """Return the tiles [ceil(H/16), ceil(W/16)] that the box of a living splat touches at normalised `time`.

    No other tile can pass a gradient to a dynamic splat, so a dynamic training step need not draw it.
    """
    across, down = -(-camera.width // TILE), -(-camera.height // TILE)
    steps = np.zeros((down + 1, across + 1), np.int64)
    with torch.no_grad():
        living = dynamic.take(torch.nonzero(alive(dynamic, time))[:, 0])
        ellipses = project(moment_of_dynamic(living, time), camera)
        low = ((ellipses.means - ellipses.half_sizes) / TILE).floor().clamp_min(0).long().cpu().numpy()
        high = ((ellipses.means + ellipses.half_sizes) / TILE).floor().long().cpu().numpy()
    high = np.minimum(high, (across - 1, down - 1)) + 1
    # A box is the sum over both axes of steps up at its start and down behind its end.
    for x, y, sign in ((low, low, 1), (high, high, 1), (low, high, -1), (high, low, -1)):
        np.add.at(steps, (y[:, 1], x[:, 0]), sign)
    return np.asarray(steps.cumsum(0).cumsum(1)[:down, :across] > 0)


def tiles_to_pixels(tiles: npt.NDArray[np.bool_], width: int, height: int) -> npt.NDArray[np.bool_]:
    """Return the mask of pixels [H, W] that the tiles cover."""
    return tiles.repeat(TILE, 0).repeat(TILE, 1)[:height, :width]
