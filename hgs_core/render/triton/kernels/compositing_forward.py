"""Front-to-back compositing of every tile."""

import triton
import triton.language as tl

from hgs_core.render.triton.kernels.compositing import blend, load_circle, tile_pixels
from hgs_core.render.triton.kernels.constants import TILE_PIXELS

__all__ = ["composite"]


@triton.jit
def composite(
    drawn_tiles,
    ranges,
    listed_splats,
    listed_t,
    listed_e,
    splats,
    background,
    rgb,
    alpha,
    depth,
    ends,
    across,
    width,
    height,
    CHUNK: tl.constexpr,
):
    """Draw one tile. `ends` [tiles] is where its list was left: every pixel had finished, or there was no more.

    `drawn_tiles` None: all. `depth` None: it was not asked for. CHUNK: splats between two looks at whether the tile is
    finished.
    """
    tile = tl.program_id(0)
    if drawn_tiles is not None:
        tile = tl.load(drawn_tiles + tile)
    dx, dy, pixel, inside = tile_pixels(tile, across, width, height)
    T = tl.where(inside, 1.0, -1.0)  # pixels beyond the picture are finished from the start
    red = tl.zeros((TILE_PIXELS,), tl.float32)
    green = tl.zeros((TILE_PIXELS,), tl.float32)
    blue = tl.zeros((TILE_PIXELS,), tl.float32)
    far = tl.zeros((TILE_PIXELS,), tl.float32)
    begin = tl.load(ranges + tile * 2)
    end = tl.load(ranges + tile * 2 + 1)
    going = begin < end
    while going:
        stop = tl.minimum(begin + CHUNK, end)
        for entry in range(begin, stop):
            _, row, middle_t, middle_e = load_circle(entry, listed_splats, listed_t, listed_e, splats)
            _, _, _, _, weight, _, T = blend(row, middle_t, middle_e, dx, dy, T)
            red += weight * tl.load(row + 4)
            green += weight * tl.load(row + 5)
            blue += weight * tl.load(row + 6)
            if depth is not None:
                far += weight * tl.load(row + 7)
        begin = stop
        going = (begin < end) & (tl.max(T, axis=0) > 0.0)
    tl.store(ends + tile, begin)
    T = tl.abs(T)
    plane = width * height
    tl.store(rgb + pixel, red + T * tl.load(background), mask=inside)
    tl.store(rgb + plane + pixel, green + T * tl.load(background + 1), mask=inside)
    tl.store(rgb + 2 * plane + pixel, blue + T * tl.load(background + 2), mask=inside)
    tl.store(alpha + pixel, 1.0 - T, mask=inside)
    if depth is not None:
        tl.store(depth + pixel, far, mask=inside)
