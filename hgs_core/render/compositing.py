"""Tile binning and front-to-back compositing in plain torch (docs/numerics.md, "Compositing").

Tiles are processed in batches of similar list length, padded to the longest, so that the same code is the float64
truth of the tests and a usable fallback where the compiled library is missing.
"""

from __future__ import annotations

from collections.abc import Iterator

import torch
from torch import Tensor

from hgs_core.render.constants import ALPHA_MAX, ALPHA_MIN, TILE, TRANSMITTANCE_MIN
from hgs_core.render.projection import Ellipses

__all__ = ["composite", "tile_lists"]

_BATCH = 2_000_000  # pixel-splat pairs evaluated at once: bounds the memory of a batch


def tile_lists(ellipses: Ellipses, width: int, height: int, tile_mask: Tensor | None) -> tuple[Tensor, Tensor]:
    """List the ellipses of every tile by depth.

    Returns:
        `(rows, starts)`: rows of `ellipses`, tile after tile in row-major order, and where each tile's list starts
        ([tiles + 1]). Ties of depth keep the order of `ellipses`.
    """
    across, down = -(-width // TILE), -(-height // TILE)
    order = torch.argsort(ellipses.depths, stable=True)
    low = ((ellipses.means - ellipses.half_sizes).detach() / TILE).floor().long()[order]
    high = ((ellipses.means + ellipses.half_sizes).detach() / TILE).floor().long()[order]
    limit = torch.tensor([across - 1, down - 1], device=low.device)
    low, high = low.clamp_min(0).minimum(limit), high.clamp_min(0).minimum(limit)
    span = high - low + 1
    counts = span[:, 0] * span[:, 1]
    entry = torch.repeat_interleave(torch.arange(len(order), device=low.device), counts)
    place = torch.arange(len(entry), device=low.device) - (counts.cumsum(0) - counts)[entry]
    tiles = (low[entry, 1] + place // span[entry, 0]) * across + low[entry, 0] + place % span[entry, 0]
    if tile_mask is not None:
        kept = tile_mask.reshape(-1)[tiles]
        tiles, entry = tiles[kept], entry[kept]
    sorting = torch.argsort(tiles, stable=True)
    starts = torch.searchsorted(tiles[sorting], torch.arange(across * down + 1, device=low.device))
    return order[entry[sorting]], starts


def composite(ellipses: Ellipses, width: int, height: int, tile_mask: Tensor | None) -> Tensor:
    """Draw the ellipses over nothing: [4, H, W], colour weighted by coverage, then coverage (1 - T)."""
    rows, starts = tile_lists(ellipses, width, height, tile_mask)
    across, down = -(-width // TILE), -(-height // TILE)
    means = ellipses.means
    lane = torch.arange(TILE * TILE, device=means.device)
    pictures: list[Tensor] = []
    places: list[Tensor] = []
    for tiles, longest in _batches(starts[1:] - starts[:-1]):
        slot = torch.arange(longest, device=means.device)
        listed = slot < (starts[1:] - starts[:-1])[tiles][:, None]  # [B, K]
        row = rows[torch.where(listed, starts[tiles][:, None] + slot, 0)]
        px = ((tiles % across) * TILE)[:, None] + lane % TILE + 0.5
        py = ((tiles // across) * TILE)[:, None] + lane // TILE + 0.5
        mean, conic = means[row], ellipses.conics[row]
        dx = px[:, None] - mean[..., :1]  # [B, K, 256]
        dy = py[:, None] - mean[..., 1:]
        power = -0.5 * (conic[..., :1] * dx * dx + conic[..., 2:] * dy * dy) - conic[..., 1:2] * dx * dy
        alpha = (ellipses.opacities[row][..., None] * torch.exp(power)).clamp_max(ALPHA_MAX)
        alpha = torch.where(listed[..., None] & (alpha >= ALPHA_MIN), alpha, torch.zeros_like(alpha))
        unfinished = torch.cumprod(1 - alpha.detach(), 1) > TRANSMITTANCE_MIN
        alpha = torch.where(unfinished, alpha, torch.zeros_like(alpha))
        passed = torch.cumprod(1 - alpha, 1)
        before = torch.cat([torch.ones_like(passed[:, :1]), passed[:, :-1]], 1)
        weight = alpha * before
        colour = torch.bmm(ellipses.rgb[row].transpose(1, 2), weight)
        pictures.append(torch.cat([colour, (1 - passed[:, -1])[:, None]], 1))
        places.append(tiles)
    stacked = torch.zeros((across * down, 4, TILE * TILE), dtype=means.dtype, device=means.device)
    if pictures:
        stacked = stacked.index_copy(0, torch.cat(places), torch.cat(pictures))
    image = stacked.view(down, across, 4, TILE, TILE).permute(2, 0, 3, 1, 4)
    return image.reshape(4, down * TILE, across * TILE)[:, :height, :width]


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
