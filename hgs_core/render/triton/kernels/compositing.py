"""Blending one splat over a tile's pixels, which all passes over the tiles share (docs/numerics.md, "Compositing").

One warp has a tile, each of its threads eight pixels: what a splat costs once is shared by many of them, and sums over
the tile need no barrier.
"""

import triton
import triton.language as tl

from hgs_core.render.triton.kernels.constants import (
    ALPHA_MAX,
    LOG2_ALPHA_MIN,
    SPLAT,
    TILE,
    TILE_PIXELS,
    TRANSMITTANCE_MIN,
)

__all__ = ["blend", "load_circle", "tile_pixels"]


@triton.jit
def tile_pixels(tile, across, width, height):
    """Of the tile's pixels: offsets from its middle, places in a plane of the picture, and whether they lie in it."""
    lane = tl.arange(0, TILE_PIXELS)
    column, line = lane % TILE, lane // TILE
    x, y = (tile % across) * TILE + column, (tile // across) * TILE + line
    middle = 0.5 * (TILE - 1)
    return column.to(tl.float32) - middle, line.to(tl.float32) - middle, y * width + x, (x < width) & (y < height)


@triton.jit
def load_circle(entry, listed_splats, listed_t, listed_e, splats):
    """The entry's splat in round coordinates: the splat, its row, and (t, e) of the middle of the tile."""
    splat = tl.load(listed_splats + entry)
    return splat, splats + splat * SPLAT, tl.load(listed_t + entry), tl.load(listed_e + entry)


@triton.jit
def blend(row, middle_t, middle_e, dx, dy, T):
    """Draw a splat over pixels of transmittance T; a finished pixel keeps its T with the sign set.

    Returns t, e, alpha before its clamp, alpha, the weight T alpha where drawn and else 0, whether it is drawn, and T
    behind it.
    """
    t = dx * tl.load(row) + (dy * tl.load(row + 1) + middle_t)
    e = dy * tl.load(row + 2) + middle_e
    power = tl.load(row + 3) - e * e - t * t
    unclamped = tl.exp2(power)
    alpha = tl.minimum(unclamped, ALPHA_MAX)
    visible = power >= LOG2_ALPHA_MIN
    attempt = tl.where(visible, alpha * T, 0.0)
    behind = T - attempt
    unfinished = behind > TRANSMITTANCE_MIN
    weight = tl.where(unfinished, attempt, 0.0)
    return t, e, unclamped, alpha, weight, visible & unfinished, tl.where(unfinished, behind, -tl.abs(T))
