"""The list of every tile: its splats by depth.

Splats are sorted by depth, put their entries into that order, and the entries are sorted by tile, stably: two sorts of
few digits in place of one of 64. Nothing depends on the order in which blocks of the kernels run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
import triton
from torch import Tensor

from hgs_core.render.constants import ENTRIES_MAX, TILE
from hgs_core.render.triton.kernels.tile_lists import count_tiles, emit_tiles, place_entries
from hgs_core.render.triton.screen import Screen, row_blocks
from hgs_core.render.types import View

__all__ = ["TileLists", "list_by_tile"]

_BLOCK = 256  # entries of a program


@dataclass(frozen=True)
class TileLists:
    """E entries (pairs of a splat and a drawn tile) of K splats, and which tiles are drawn."""

    across: int  # tiles
    drawn_tiles: Tensor | None  # [D] int32, row-major; None: all
    tiles: int  # drawn tiles
    counts: Tensor  # [K] int32 entries of each splat
    first_entries: Tensor  # [K] int64 of each splat, before sorting by tile
    order: Tensor  # [E] int64 where each entry was before
    splats: Tensor  # [E] int32
    middle_t: Tensor  # [E] float32 round coordinates of the middle of the tile
    middle_e: Tensor  # [E] float32
    ranges: Tensor  # [tiles, 2] int32 where each tile's entries begin and end
    entries_static: int
    entries_dynamic: int


def list_by_tile(screen: Screen, view: View) -> TileLists | None:
    """Make the lists; None if a parameter is refused.

    Raises:
        RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
    """
    device, splats = screen.depths.device, len(screen.depths)
    across, down = -(-view.camera.width // TILE), -(-view.camera.height // TILE)
    drawn_tiles, tiles_before, drawn = _drawn(view.tile_mask, device)
    masked = view.tile_mask is not None
    counts = torch.zeros(splats, dtype=torch.int32, device=device)
    if splats:
        grid, options = row_blocks(splats)
        count_tiles[grid](
            screen.depths,
            screen.ellipses,
            screen.boxes,
            tiles_before,
            counts,
            screen.tally,
            splats,
            screen.statics,
            across,
            MASKED=masked,
            enable_fp_fusion=False,
            **options,
        )
    by_depth = torch.sort(screen.depths, stable=True).indices
    sorted_counts = counts[by_depth]
    ends = sorted_counts.cumsum(0, dtype=torch.int64)
    first_entries = torch.empty(splats, dtype=torch.int64, device=device)
    first_entries[by_depth] = ends - sorted_counts
    refused, statics, dynamics = screen.tally.tolist()  # the one time that the host waits for the device
    if refused:
        return None
    entries = statics + dynamics
    if entries > ENTRIES_MAX:
        raise RuntimeError("the splats cover more than 2^31 - 1 tiles: render fewer, smaller or less")

    entry_splats = torch.repeat_interleave(by_depth.int(), sorted_counts, output_size=entries)
    tiles = torch.empty(entries, dtype=torch.int16 if across * down < 1 << 15 else torch.int32, device=device)
    grid = (triton.cdiv(entries, _BLOCK),)
    if entries:
        emit_tiles[grid](
            entry_splats,
            first_entries,
            screen.ellipses,
            screen.boxes,
            tiles_before,
            drawn_tiles,
            tiles,
            entries,
            across,
            MASKED=masked,
            BLOCK=_BLOCK,
            enable_fp_fusion=False,
        )
    tiles, order = torch.sort(tiles, stable=True)
    lists = TileLists(
        across,
        drawn_tiles,
        across * down if drawn is None else drawn,
        counts,
        first_entries,
        order,
        torch.empty_like(entry_splats),
        torch.empty(entries, dtype=torch.float32, device=device),
        torch.empty(entries, dtype=torch.float32, device=device),
        torch.zeros((across * down, 2), dtype=torch.int32, device=device),
        statics,
        dynamics,
    )
    if entries:
        place_entries[grid](
            tiles,
            order,
            entry_splats,
            screen.splats,
            screen.places,
            lists.splats,
            lists.middle_t,
            lists.middle_e,
            lists.ranges,
            entries,
            across,
            BLOCK=_BLOCK,
        )
    return lists


def _drawn(mask: npt.NDArray[np.bool_] | None, device: torch.device) -> tuple[Tensor | None, Tensor | None, int | None]:
    """Return the drawn tiles, how many of them lie before each tile ([tiles + 1]), and how many there are."""
    if mask is None:
        return None, None, None
    flat = np.ascontiguousarray(mask, np.bool_).reshape(-1)
    chosen = np.flatnonzero(flat).astype(np.int32)
    before = np.concatenate([[0], np.cumsum(flat)]).astype(np.int32)
    return torch.from_numpy(chosen).to(device), torch.from_numpy(before).to(device), len(chosen)
