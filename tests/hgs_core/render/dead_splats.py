"""Dynamic splats that are invisible at the moment: every backend must draw nothing."""

from __future__ import annotations

import math
from collections.abc import Callable

import torch

from hgs_core.render.types import Render
from hgs_core.scene import DynamicSplats


def check_the_dead_are_not_looked_at(
    splats: DynamicSplats[torch.Tensor], draw: Callable[[DynamicSplats[torch.Tensor]], Render]
) -> None:
    """Kill every other splat, make its parameters unusable, and draw: picture and gradients are those of the living.

    The temporal precisions must be such that an offset of 9 is beyond any life.
    """
    splats.time_centers[::2] = 9
    for field in ("motion", "rotation", "log_scales", "rgb"):
        getattr(splats, field)[::2] = math.nan
    splats.rgb[::4] = 1e30
    splats = splats.map(lambda array: array.requires_grad_())
    render = draw(splats)
    render.rgb.sum().backward()  # type: ignore[no-untyped-call]
    assert torch.isfinite(render.rgb).all()
    assert render.alpha.any()
    for name, array in splats.items():
        assert array.grad is not None, name
        assert torch.isfinite(array.grad).all(), name
        assert not array.grad[::2].any(), name
