"""Forward: projection, lists, pictures."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.render.finite import refuse_non_finite
from hgs_core.render.triton.kernels.compositing_forward import composite
from hgs_core.render.triton.lists import TileLists, list_by_tile
from hgs_core.render.triton.screen import Screen, project
from hgs_core.render.types import Render, View
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["Drawn", "draw"]

_CHUNK = 32  # splats between two looks at whether a tile is finished


@dataclass(frozen=True)
class Drawn:
    """The state for the derivative besides the pictures."""

    screen: Screen
    lists: TileLists
    ends: Tensor  # [tiles] int32 entry at which every pixel of the tile was finished, or the end of its list


def draw(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View, device: torch.device
) -> tuple[Drawn, Render]:
    """Draw contiguous float32 splats on `device`.

    Raises:
        InputError: a parameter that is not finite.
        RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
    """
    screen = project(static, dynamic, view, device)
    lists = list_by_tile(screen, view)
    if lists is None:
        refuse_non_finite(static, dynamic, view.time)
        raise FloatingPointError("a parameter of a splat is NaN or infinite, or a colour beyond 1e18")
    width, height = view.camera.width, view.camera.height
    background = torch.tensor(view.background, dtype=torch.float32, device=device)
    rgb = torch.empty((3, height, width), device=device)
    alpha = torch.empty((height, width), device=device)
    depth = torch.empty((height, width), device=device) if view.depth else None
    if lists.drawn_tiles is not None:  # the other tiles are not visited
        rgb.copy_(background[:, None, None].expand_as(rgb))
        alpha.zero_()
        if depth is not None:
            depth.zero_()
    ends = torch.zeros(len(lists.ranges), dtype=torch.int32, device=device)
    if lists.tiles:
        composite[(lists.tiles,)](
            lists.drawn_tiles,
            lists.ranges,
            lists.splats,
            lists.middle_t,
            lists.middle_e,
            screen.splats,
            background,
            rgb,
            alpha,
            depth,
            ends,
            lists.across,
            width,
            height,
            CHUNK=_CHUNK,
            num_warps=1,
        )
    return Drawn(screen, lists, ends), Render(rgb, alpha, depth)
