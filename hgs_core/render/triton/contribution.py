"""Contributions of the splats (`hgs_core.render.contributions`) by the Triton kernels."""

from __future__ import annotations

import torch
from torch import Tensor

from hgs_core.render.triton.device import launching_on, require_device
from hgs_core.render.triton.differentiate import reduced
from hgs_core.render.triton.draw import draw
from hgs_core.render.triton.kernels.contributions import weigh
from hgs_core.render.triton.rasterize import prepared_for
from hgs_core.render.types import Contributions, View
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["contributions_triton"]


def contributions_triton(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View
) -> Contributions:
    """Weigh the splats as `hgs_core.render.contributions` describes; raises the errors of `rasterize_triton`."""
    colours = [splats.rgb for splats in (static, dynamic) if splats is not None]
    device = require_device(colours[0] if colours else None)
    static, dynamic = prepared_for(device, static, False), prepared_for(device, dynamic, False)
    with launching_on(device):
        drawn, _ = draw(static, dynamic, view, device)
        screen, lists = drawn.screen, drawn.lists
        slots = torch.zeros((len(lists.order), 2), device=device)
        if len(lists.order):
            weigh[(lists.tiles,)](
                lists.drawn_tiles,
                lists.ranges,
                drawn.ends,
                lists.splats,
                lists.middle_t,
                lists.middle_e,
                lists.order,
                screen.splats,
                slots,
                lists.across,
                view.camera.width,
                view.camera.height,
                num_warps=1,
            )
        weighed = reduced(slots, lists.first_entries, lists.counts, maxima=1).cpu().numpy()
    return Contributions(weighed[:, 0].copy(), weighed[:, 1].copy())
