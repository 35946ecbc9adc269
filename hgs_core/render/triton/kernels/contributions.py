"""The part of a tile in every splat's contribution: the sum of its weights over the tile's pixels, and the largest."""

import triton
import triton.language as tl

from hgs_core.render.triton.kernels.compositing import blend, load_circle, tile_pixels

__all__ = ["weigh"]


@triton.jit
def weigh(
    drawn_tiles,
    ranges,
    ends,
    listed_splats,
    listed_t,
    listed_e,
    order,
    splats,
    slots,
    across,
    width,
    height,
):
    """Write (sum, largest) for every entry that compositing came to; the other slots [entries, 2] stay as they are."""
    tile = tl.program_id(0)
    if drawn_tiles is not None:
        tile = tl.load(drawn_tiles + tile)
    dx, dy, _pixel, inside = tile_pixels(tile, across, width, height)
    T = tl.where(inside, 1.0, -1.0)
    for entry in range(tl.load(ranges + tile * 2), tl.load(ends + tile)):
        _, row, middle_t, middle_e = load_circle(entry, listed_splats, listed_t, listed_e, splats)
        _, _, _, _, weight, _, T = blend(row, middle_t, middle_e, dx, dy, T)
        slot = tl.load(order + entry)
        tl.store(slots + slot * 2, tl.sum(weight, axis=0))
        tl.store(slots + slot * 2 + 1, tl.max(weight, axis=0))
