"""Backward: from the gradients of the pictures to those of the parameters."""

from __future__ import annotations

from typing import Any

import torch
import triton
from torch import Tensor

from hgs_core.render.triton.draw import Drawn
from hgs_core.render.triton.kernels import constants
from hgs_core.render.triton.kernels.compositing_backward import composite_backward
from hgs_core.render.triton.kernels.projection_backward import differentiate_dynamics, differentiate_statics
from hgs_core.render.triton.kernels.segments import reduce_slots
from hgs_core.render.triton.screen import row_blocks
from hgs_core.render.types import Render, ScreenStatistics
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["differentiate", "reduced"]

_ROWS, _LANES = 4, 16  # splats of a program that sums slots, and slots of each that it reads at a time


def differentiate(
    drawn: Drawn,
    pictures: Render,
    static: StaticSplats[Tensor] | None,
    dynamic: DynamicSplats[Tensor] | None,
    grad_rgb: Tensor,  # [3, H, W]
    grad_alpha: Tensor | None,  # [H, W]
    grad_depth: Tensor | None,  # [H, W]
    grad_static: StaticSplats[Tensor | None] | None,  # overwritten; None: not wanted
    grad_dynamic: DynamicSplats[Tensor | None] | None,
    statistics: ScreenStatistics | None,
    antialiased: bool,
) -> None:
    """Differentiate towards the arrays that are given somewhere to write to; a set without any costs nothing."""
    screen, lists = drawn.screen, drawn.lists
    wants_static = grad_static is not None and any(array is not None for _, array in grad_static.items())
    wants_dynamic = grad_dynamic is not None and any(array is not None for _, array in grad_dynamic.items())
    first = 0 if wants_static else screen.statics
    last = len(screen.depths) if wants_dynamic else screen.statics
    if first >= last:
        return
    # Wanted splats have their slots one after the other, in the order of their rows.
    counts = lists.counts[first:last]
    first_slots = torch.zeros(len(screen.depths), dtype=torch.int64, device=counts.device)
    first_slots[first:last] = counts.cumsum(0, dtype=torch.int64) - counts
    total = lists.entries_static * wants_static + lists.entries_dynamic * wants_dynamic
    slots = torch.zeros((total, constants.TERMS.value), device=counts.device)
    if total:
        composite_backward[(lists.tiles,)](
            lists.drawn_tiles,
            lists.ranges,
            drawn.ends,
            lists.splats,
            lists.middle_t,
            lists.middle_e,
            lists.order,
            first_slots - lists.first_entries,
            screen.splats,
            *pictures,
            grad_rgb,
            grad_alpha,
            grad_depth,
            slots,
            first,
            last,
            lists.across,
            *reversed(pictures.alpha.shape),
            PULLS=statistics is not None,
            num_warps=1,
        )
    sums = reduced(slots, first_slots[first:last], counts)
    pulls = None if statistics is None else torch.empty(last - first, device=counts.device)
    options: dict[str, Any]
    if grad_static is not None and wants_static and static is not None and len(static):
        grid, options = row_blocks(len(static))
        differentiate_statics[grid](
            static.means,
            static.log_scales,
            static.quats,
            static.opacity_logits,
            len(static),
            screen.camera,
            screen.depths,
            sums,
            pulls,
            *(array for _, array in grad_static.items()),
            ANTIALIASED=antialiased,
            **options,
        )
    if grad_dynamic is not None and wants_dynamic and dynamic is not None and len(dynamic):
        grid, options = row_blocks(len(dynamic))
        skipped = screen.statics - first
        differentiate_dynamics[grid](
            *(array for name, array in dynamic.items() if name != "rgb"),
            len(dynamic),
            screen.camera,
            screen.depths[screen.statics :],
            sums[skipped:],
            None if pulls is None else pulls[skipped:],
            *(array for _, array in grad_dynamic.items()),
            COEFFICIENTS=dynamic.motion.shape[1],
            ANTIALIASED=antialiased,
            **options,
        )
    if statistics is not None and pulls is not None:
        added = pulls.cpu().numpy()
        statistics.pull_sum[first:last] += added
        statistics.count[first:last] += added > 0


def reduced(slots: Tensor, first_slots: Tensor, counts: Tensor, maxima: int = 0) -> Tensor:
    """Return the sum of every row's slots [K, width], or the maxima of the last `maxima` columns."""
    rows, width = len(counts), slots.shape[1]
    totals = torch.empty((rows, width), device=slots.device)
    if rows:
        reduce_slots[(triton.cdiv(rows, _ROWS),)](
            slots,
            first_slots,
            counts,
            totals,
            rows,
            WIDTH=width,
            MAXIMA=maxima,
            ROWS=_ROWS,
            LANES=_LANES,
            COLUMNS=triton.next_power_of_2(width),
            num_warps=1,
        )
    return totals
