"""The derivative of compositing, front to back like compositing itself.

A pixel's light is its colour and its depth. With g the gradient of that light, G that of the alpha channel and B the
background, splat i of light c_i and weight w_i = T_i alpha_i has

    dL / d alpha_i = T_i g.c_i - (S - w_i g.c_i) / (1 - alpha_i),   S = sum of w_j g.c_j over j >= i + T_end (g.B - G)

and before the first splat S is known from the picture: g.light - G T_end. 1 - alpha is at least 0.01.
"""

import triton
import triton.language as tl

from hgs_core.render.triton.kernels.compositing import blend, load_circle, tile_pixels
from hgs_core.render.triton.kernels.constants import ALPHA_MAX, TERMS, TILE_PIXELS

__all__ = ["composite_backward"]


@triton.jit
def composite_backward(
    drawn_tiles,
    ranges,
    ends,
    listed_splats,
    listed_t,
    listed_e,
    order,
    slot_shifts,
    splats,
    rgb,
    alpha,
    depth,
    grad_rgb,
    grad_alpha,
    grad_depth,
    slots,
    first_wanted,
    last_wanted,
    across,
    width,
    height,
    PULLS: tl.constexpr,
):
    """Write, for every wanted entry of a tile, the tile's part of the splat's gradient.

    Splats from `first_wanted` to before `last_wanted` are wanted; entry `order[i] + slot_shifts[splat]` of `slots` is
    theirs, and those that the forward pass did not come to stay as they are. `grad_alpha` and `grad_depth` may be None.
    PULLS: whether the statistics need their sums of magnitudes.
    """
    tile = tl.program_id(0)
    if drawn_tiles is not None:
        tile = tl.load(drawn_tiles + tile)
    dx, dy, pixel, inside = tile_pixels(tile, across, width, height)
    T = tl.where(inside, 1.0, -1.0)
    plane = width * height
    g_red = tl.load(grad_rgb + pixel, mask=inside, other=0.0)
    g_green = tl.load(grad_rgb + plane + pixel, mask=inside, other=0.0)
    g_blue = tl.load(grad_rgb + 2 * plane + pixel, mask=inside, other=0.0)
    rest = g_red * tl.load(rgb + pixel, mask=inside, other=0.0)
    rest += g_green * tl.load(rgb + plane + pixel, mask=inside, other=0.0)
    rest += g_blue * tl.load(rgb + 2 * plane + pixel, mask=inside, other=0.0)
    g_far = tl.zeros((TILE_PIXELS,), tl.float32)
    if grad_depth is not None:
        g_far = tl.load(grad_depth + pixel, mask=inside, other=0.0)
        rest += g_far * tl.load(depth + pixel, mask=inside, other=0.0)
    if grad_alpha is not None:
        covered = tl.load(alpha + pixel, mask=inside, other=0.0)
        rest -= tl.load(grad_alpha + pixel, mask=inside, other=0.0) * (1.0 - covered)
    for entry in range(tl.load(ranges + tile * 2), tl.load(ends + tile)):
        splat, row, middle_t, middle_e = load_circle(entry, listed_splats, listed_t, listed_e, splats)
        before = T
        t, e, unclamped, opaque, weight, drawn, T = blend(row, middle_t, middle_e, dx, dy, T)
        along = g_red * tl.load(row + 4) + (g_green * tl.load(row + 5) + g_blue * tl.load(row + 6))
        if grad_depth is not None:
            along += g_far * tl.load(row + 7)
        rest -= weight * along
        if (splat >= first_wanted) & (splat < last_wanted):
            d_alpha = before * along - rest / (1.0 - opaque)
            h = tl.where(drawn & (unclamped <= ALPHA_MAX), d_alpha * unclamped, 0.0)
            ht, he = h * t, h * e
            slot = tl.load(order + entry) + tl.load(slot_shifts + splat)
            at = slots + slot * TERMS
            tl.store(at, tl.sum(ht, axis=0))
            tl.store(at + 1, tl.sum(he, axis=0))
            tl.store(at + 2, tl.sum(ht * t, axis=0))
            tl.store(at + 3, tl.sum(ht * e, axis=0))
            tl.store(at + 4, tl.sum(he * e, axis=0))
            tl.store(at + 5, tl.sum(weight * g_red, axis=0))
            tl.store(at + 6, tl.sum(weight * g_green, axis=0))
            tl.store(at + 7, tl.sum(weight * g_blue, axis=0))
            tl.store(at + 8, tl.sum(h, axis=0))
            if grad_depth is not None:
                tl.store(at + 9, tl.sum(weight * g_far, axis=0))
            if PULLS:
                tl.store(at + 10, tl.sum(tl.abs(ht), axis=0))
                tl.store(at + 11, tl.sum(tl.abs(ht * tl.load(row + 1) + he * tl.load(row + 2)), axis=0))
