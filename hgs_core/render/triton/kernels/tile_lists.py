"""Which tiles a splat's visible ellipse reaches, and the lists of the tiles.

The ellipse's part in a row of tiles is convex, so the tiles that it reaches there are those between its ends. Counting
and listing must find the same ones: both are launched without fused multiply-adds, which compilers place differently in
different kernels.
"""

import triton
import triton.language as tl

from hgs_core.render.triton.kernels.constants import ELLIPSE, PLACE, SPLAT, TILE

__all__ = ["count_tiles", "emit_tiles", "place_entries"]


@triton.jit
def covered_tiles(splat, tile_y, mask, ellipses, boxes, tiles_before, across, MASKED: tl.constexpr):
    """The drawn tiles that splats reach in one row of tiles each.

    Returns the number of the first of them among the drawn tiles, and how many they are.
    """
    at = ellipses + splat * ELLIPSE
    mean_x = tl.load(at, mask=mask, other=0.0)
    mean_y = tl.load(at + 1, mask=mask, other=0.0)
    shear = tl.load(at + 2, mask=mask, other=0.0)  # C_xy / C_yy: the middles of the chords along x lie at dx = shear dy
    half_width = tl.load(at + 3, mask=mask, other=1.0)  # sqrt(det C / C_yy)
    reach = tl.load(at + 4, mask=mask, other=0.0)  # 2 ln(255 o)
    inverse_yy = tl.load(at + 5, mask=mask, other=0.0)
    dy_of_right = tl.load(at + 6, mask=mask, other=0.0)  # dy of the ellipse's rightmost point
    slack = tl.load(at + 7, mask=mask, other=0.0)
    at = boxes + splat * 4
    x0 = tl.load(at, mask=mask, other=1)
    x1 = tl.load(at + 1, mask=mask, other=0)
    top_row = tl.maximum(tl.load(at + 2, mask=mask, other=1), tile_y * TILE)
    bottom_row = tl.minimum(tl.load(at + 3, mask=mask, other=0), tile_y * TILE + (TILE - 1))

    top = top_row.to(tl.float32) + 0.5 - mean_y - slack
    bottom = bottom_row.to(tl.float32) + 0.5 - mean_y + slack
    right = tl.minimum(tl.maximum(dy_of_right, top), bottom)
    left = tl.minimum(tl.maximum(-dy_of_right, top), bottom)
    chord_right = half_width * tl.sqrt(tl.maximum(reach - right * right * inverse_yy, 0.0))
    chord_left = half_width * tl.sqrt(tl.maximum(reach - left * left * inverse_yy, 0.0))
    low = tl.ceil(mean_x + shear * left - chord_left - (0.5 + slack))
    high = tl.floor(mean_x + shear * right + chord_right - (0.5 - slack))
    first = tl.minimum(tl.maximum(low, x0.to(tl.float32)), x1.to(tl.float32) + 1.0).to(tl.int32)
    last = tl.maximum(tl.minimum(high, x1.to(tl.float32)), x0.to(tl.float32) - 1.0).to(tl.int32)
    some = mask & (top_row <= bottom_row) & (first <= last)
    from_tile = tile_y * across + first // TILE
    to_tile = tile_y * across + last // TILE
    if MASKED:
        begin = tl.load(tiles_before + from_tile, mask=some, other=0)
        end = tl.load(tiles_before + to_tile + 1, mask=some, other=0)
    else:
        begin, end = from_tile, to_tile + 1
    return begin, tl.where(some, end - begin, 0)


@triton.jit
def count_tiles(
    depths,
    ellipses,
    boxes,
    tiles_before,
    counts,
    tally,
    count,
    statics,
    across,
    MASKED: tl.constexpr,
    BLOCK: tl.constexpr,
):
    """In how many drawn tiles each splat is; adds the sums over statics and dynamics to the second and third tally."""
    splat = tl.program_id(0) * BLOCK + tl.arange(0, BLOCK)
    mask = splat < count
    seen = mask & (tl.load(depths + splat, mask=mask, other=float("inf")) < float("inf"))
    first = tl.load(boxes + splat * 4 + 2, mask=seen, other=0) // TILE
    last = tl.load(boxes + splat * 4 + 3, mask=seen, other=-1)
    rows = tl.where(seen & (last >= 0), last // TILE - first + 1, 0)
    total = tl.zeros((BLOCK,), tl.int32)
    for i in range(tl.max(rows, axis=0)):
        _, tiles = covered_tiles(splat, first + i, i < rows, ellipses, boxes, tiles_before, across, MASKED)
        total += tiles
    tl.store(counts + splat, total, mask=mask)
    total = total.to(tl.int64)
    tl.atomic_add(tally + 1, tl.sum(tl.where(splat < statics, total, 0), axis=0))
    tl.atomic_add(tally + 2, tl.sum(tl.where(splat < statics, 0, total), axis=0))


@triton.jit
def emit_tiles(
    entry_splats,
    first_entries,
    ellipses,
    boxes,
    tiles_before,
    drawn_tiles,
    entry_tiles,
    count,
    across,
    MASKED: tl.constexpr,
    BLOCK: tl.constexpr,
):
    """The tile of every entry: entry `first_entries[splat] + k` is the splat's k-th tile."""
    entry = tl.program_id(0).to(tl.int64) * BLOCK + tl.arange(0, BLOCK)
    mask = entry < count
    splat = tl.load(entry_splats + entry, mask=mask, other=0)
    left = (entry - tl.load(first_entries + splat, mask=mask, other=0)).to(tl.int32)
    first = tl.load(boxes + splat * 4 + 2, mask=mask, other=0) // TILE
    rows = tl.where(mask, tl.load(boxes + splat * 4 + 3, mask=mask, other=0) // TILE - first + 1, 0)
    tile = tl.zeros((BLOCK,), tl.int32)
    searching = mask
    for i in range(tl.max(rows, axis=0)):
        begin, tiles = covered_tiles(
            splat, first + i, searching & (i < rows), ellipses, boxes, tiles_before, across, MASKED
        )
        found = searching & (left < tiles)
        tile = tl.where(found, begin + left, tile)
        left -= tiles
        searching = searching & (left >= 0)
    if MASKED:
        tile = tl.load(drawn_tiles + tile, mask=mask, other=0)
    tl.store(entry_tiles + entry, tile.to(entry_tiles.dtype.element_ty), mask=mask)


@triton.jit
def place_entries(
    tiles,
    order,
    entry_splats,
    splats,
    places,
    listed_splats,
    listed_t,
    listed_e,
    ranges,
    count,
    across,
    BLOCK: tl.constexpr,
):
    """The sorted lists: splat, and (t, e) of the middle of the tile, of every entry; where each tile's list lies.

    `tiles` and `order` are the sorted tiles and the entries they came from; `ranges` [tiles, 2] starts as zeros. In
    float64, so that within the tile t takes small steps from a small number, however long the needle.
    """
    entry = tl.program_id(0).to(tl.int64) * BLOCK + tl.arange(0, BLOCK)
    mask = entry < count
    tile = tl.load(tiles + entry, mask=mask, other=0).to(tl.int32)
    splat = tl.load(entry_splats + tl.load(order + entry, mask=mask, other=0), mask=mask, other=0)
    at = places + splat * PLACE
    x = ((tile % across) * TILE + TILE // 2).to(tl.float64) - tl.load(at, mask=mask, other=0.0)
    y = ((tile // across) * TILE + TILE // 2).to(tl.float64) - tl.load(at + 1, mask=mask, other=0.0)
    t_by_x = tl.load(splats + splat * SPLAT, mask=mask, other=0.0)
    e_by_y = tl.load(splats + splat * SPLAT + 2, mask=mask, other=0.0)
    t = t_by_x.to(tl.float64) * (x + tl.load(at + 2, mask=mask, other=0.0) * y)
    tl.store(listed_splats + entry, splat, mask=mask)
    tl.store(listed_t + entry, t.to(tl.float32), mask=mask)
    tl.store(listed_e + entry, (e_by_y.to(tl.float64) * y).to(tl.float32), mask=mask)
    before = tl.load(tiles + entry - 1, mask=mask & (entry > 0), other=-1).to(tl.int32)
    after = tl.load(tiles + entry + 1, mask=mask & (entry + 1 < count), other=-1).to(tl.int32)
    tl.store(ranges + tile * 2, entry.to(tl.int32), mask=mask & (before != tile))
    tl.store(ranges + tile * 2 + 1, (entry + 1).to(tl.int32), mask=mask & (after != tile))
