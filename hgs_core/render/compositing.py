"""Tile binning and front-to-back compositing in plain torch (docs/numerics.md, "Compositing").

Tiles are processed in batches of similar list length, padded to the longest, so that the same code is the float64
truth of the tests and a usable fallback where the compiled library is missing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import torch
from torch import Tensor

from hgs_core.render.constants import ALPHA_MAX, ALPHA_MIN, ENTRIES_MAX, TILE, TRANSMITTANCE_MIN
from hgs_core.render.projection import Ellipses

__all__ = ["Weights", "blend", "composite", "tile_lists"]

_BATCH = 2_000_000  # pixel-splat pairs evaluated at once: bounds the memory of a batch


def tile_lists(ellipses: Ellipses, width: int, height: int, tile_mask: Tensor | None) -> tuple[Tensor, Tensor]:
    """List the ellipses of every tile by depth.

    Returns:
        `(rows, starts)`: rows of `ellipses`, tile after tile in row-major order, and where each tile's list starts
        ([tiles + 1]). Ties of depth keep the order of `ellipses`.

    Raises:
        RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
    """
    across, down = -(-width // TILE), -(-height // TILE)
    # In float32, so that every backend sees the same ties.
    order = torch.argsort(ellipses.depths.detach().float(), stable=True)
    low = ((ellipses.means - ellipses.half_sizes).detach() / TILE).floor().clamp_min(0).long()[order]
    limit = torch.tensor([across - 1, down - 1], device=low.device)
    high = ((ellipses.means + ellipses.half_sizes).detach() / TILE).floor().minimum(limit).long()[order]
    span = high - low + 1
    counts = span[:, 0] * span[:, 1]
    if int(counts.sum()) > ENTRIES_MAX:
        raise RuntimeError("the splats cover more than 2^31 - 1 tiles: render fewer, smaller or less")
    entry = torch.repeat_interleave(torch.arange(len(order), device=low.device), counts)
    place = torch.arange(len(entry), device=low.device) - (counts.cumsum(0) - counts)[entry]
    tiles = (low[entry, 1] + place // span[entry, 0]) * across + low[entry, 0] + place % span[entry, 0]
    if tile_mask is not None:
        kept = tile_mask.reshape(-1)[tiles]
        tiles, entry = tiles[kept], entry[kept]
    sorting = torch.argsort(tiles, stable=True)
    starts = torch.searchsorted(tiles[sorting], torch.arange(across * down + 1, device=low.device))
    return order[entry[sorting]], starts


@dataclass(frozen=True)
class Weights:
    """The pixels of B tiles, K splats deep."""

    tiles: Tensor  # [B] row-major
    rows: Tensor  # [B, K] of the ellipses; meaningless where the weights are all zero
    weights: Tensor  # [B, K, 256] T alpha, also in the pixels of a tile that lie beyond the picture
    coverage: Tensor  # [B, 256] 1 - T behind the last splat


def blend(
    ellipses: Ellipses,
    width: int,
    height: int,
    tile_mask: Tensor | None,
    dtype: torch.dtype,
    pulls: Tensor | None = None,
) -> Iterator[Weights]:
    """Blend the ellipses front to back in every tile that has some, computing pixels in `dtype`.

    The backward pass adds to `pulls` [N, 2], for every ellipse, the sums over pixels of |dL / d mean| in x and in y.
    """
    rows, starts = tile_lists(ellipses, width, height, tile_mask)
    across = -(-width // TILE)
    lane = torch.arange(TILE * TILE, device=rows.device)
    px, py = (lane % TILE + 0.5).to(dtype), (lane // TILE + 0.5).to(dtype)  # pixel centres within the tile
    for tiles, longest in _batches(starts[1:] - starts[:-1]):
        slot = torch.arange(longest, device=rows.device)
        listed = slot < (starts[1:] - starts[:-1])[tiles][:, None]  # [B, K]
        row = rows[torch.where(listed, starts[tiles][:, None] + slot, 0)]
        # U (pixel - mean) = U (pixel - tile) - U (mean - tile): what is large cancels in float64, once per tile, and
        # the exponent is a sum of squares, which rounding cannot make positive.
        corner = torch.stack([tiles % across, tiles // across], 1)[:, None] * TILE
        (ox, oy), (xx, xy, yy) = (ellipses.means[row] - corner).unbind(-1), ellipses.factors[row].unbind(-1)
        ex, ey = (xx * ox + xy * oy).to(dtype)[..., None], (yy * oy).to(dtype)[..., None]
        xx, xy, yy = xx.to(dtype)[..., None], xy.to(dtype)[..., None], yy.to(dtype)[..., None]
        offsets = torch.stack([xx * px + xy * py - ex, yy * py - ey], -1)
        if pulls is not None and offsets.requires_grad:
            offsets.register_hook(  # type: ignore[no-untyped-call]
                partial(_pull, pulls, row, ellipses.factors.detach()[row])
            )
        distance = offsets.square().sum(-1)  # [B, K, 256]
        opacity = ellipses.opacities[row].to(dtype)[..., None]
        alpha = (opacity * torch.exp(-0.5 * distance)).clamp_max(ALPHA_MAX)
        alpha = torch.where(listed[..., None] & (alpha >= ALPHA_MIN), alpha, torch.zeros_like(alpha))
        unfinished = torch.cumprod(1 - alpha.detach(), 1) > TRANSMITTANCE_MIN
        alpha = torch.where(unfinished, alpha, torch.zeros_like(alpha))
        passed = torch.cumprod(1 - alpha, 1)
        before = torch.cat([torch.ones_like(passed[:, :1]), passed[:, :-1]], 1)
        yield Weights(tiles, row, alpha * before, 1 - passed[:, -1])


def composite(
    ellipses: Ellipses,
    width: int,
    height: int,
    tile_mask: Tensor | None,
    dtype: torch.dtype,
    depth: bool,
    pulls: Tensor | None = None,
) -> Tensor:
    """Draw the ellipses over nothing: colour, coverage (1 - T) and, if asked, weighted depth, [4 or 5, H, W].

    `pulls`: see `blend`.
    """
    across, down = -(-width // TILE), -(-height // TILE)
    values = torch.cat([ellipses.rgb, ellipses.depths[:, None]], 1) if depth else ellipses.rgb
    values = values.to(dtype)
    pictures: list[Tensor] = []
    places: list[Tensor] = []
    for batch in blend(ellipses, width, height, tile_mask, dtype, pulls):
        shown = torch.bmm(values[batch.rows].transpose(1, 2), batch.weights)
        pictures.append(torch.cat([shown[:, :3], batch.coverage[:, None], shown[:, 3:]], 1))
        places.append(batch.tiles)
    # Nothing of every parameter, so that a picture that shows none of them still has a derivative: zero.
    fields = (ellipses.means, ellipses.factors, ellipses.opacities, values)
    nothing = sum((field[:0].sum().to(dtype) for field in fields), torch.zeros((), dtype=dtype, device=values.device))
    stacked = nothing.expand(across * down, values.shape[1] + 1, TILE * TILE)
    if pictures:
        stacked = stacked.index_copy(0, torch.cat(places), torch.cat(pictures))
    image = stacked.view(down, across, -1, TILE, TILE).permute(2, 0, 3, 1, 4)
    return image.reshape(-1, down * TILE, across * TILE)[:, :height, :width]


def _pull(pulls: Tensor, rows: Tensor, factors: Tensor, gradient: Tensor) -> None:
    """Add pulls to `pulls`, from the gradient [B, K, 256, 2] of pixels' offsets in round coordinates."""
    (xx, xy, yy), (by_t, by_e) = factors[..., None, :].unbind(-1), gradient.unbind(-1)
    by_mean = torch.stack([xx * by_t, xy * by_t + yy * by_e], -1)
    pulls.index_add_(0, rows.flatten(), by_mean.abs().sum(2).flatten(0, 1))


def _batches(lengths: Tensor) -> Iterator[tuple[Tensor, int]]:
    """Group the tiles with splats by list length; yields (tile numbers [B], longest list)."""
    order = torch.argsort(lengths)
    sizes = lengths[order].tolist()
    first = next((i for i, size in enumerate(sizes) if size > 0), len(sizes))
    while first < len(sizes):
        last = first + 1
        while (
            last < len(sizes)
            and (last + 1 - first) * sizes[last] * TILE * TILE <= _BATCH
            and sizes[last] <= max(8, 2 * sizes[first])
        ):
            last += 1
        yield order[first:last], sizes[last - 1]
        first = last
