"""The Triton backend behind autograd: float32 pixels, float64 wherever a splat is computed once."""

from __future__ import annotations

import dataclasses
from typing import Any, TypeVar

import torch
from torch import Tensor

from hgs_core.render.triton.device import launching_on, require_device
from hgs_core.render.triton.differentiate import differentiate
from hgs_core.render.triton.draw import draw
from hgs_core.render.types import Render, View
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["prepared_for", "rasterize_triton"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])


def rasterize_triton(static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View) -> Render:
    """Render as `hgs_core.render.rasterize` describes, in float32.

    Splats that lie elsewhere are copied to the device; the pictures lie where the splats do.

    Raises:
        InputError: no Triton, no CUDA device, or a parameter that is not finite.
        RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
    """
    colours = [splats.rgb for splats in (static, dynamic) if splats is not None]
    device = require_device(colours[0] if colours else None)
    home = colours[0].device if colours else device
    static = prepared_for(device, static, view.gradients in ("all", "static"))
    dynamic = prepared_for(device, dynamic, view.gradients in ("all", "dynamic"))
    tensors = [array for splats in (static, dynamic) if splats is not None for _, array in splats.items()]
    with launching_on(device):
        rgb, alpha, depth = _Rasterize.apply(  # type: ignore[no-untyped-call]
            view, device, static is not None, *tensors
        )
    return Render(rgb.to(home), alpha.to(home), None if depth is None else depth.to(home))


def prepared_for(device: torch.device, splats: S | None, wanted: bool) -> S | None:
    """Make the fields contiguous float32 tensors on the device, cut off from autograd if no gradient is wanted."""
    if splats is None:
        return None
    return splats.map(lambda array: (array if wanted else array.detach()).to(device, torch.float32).contiguous())


class _Rasterize(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any, view: View, device: torch.device, has_static: bool, *tensors: Tensor
    ) -> tuple[Tensor, Tensor, Tensor | None]:
        n = len(dataclasses.fields(StaticSplats)) if has_static else 0
        static = StaticSplats(*tensors[:n]) if n else None
        dynamic = DynamicSplats(*tensors[n:]) if tensors[n:] else None
        drawn, pictures = draw(static, dynamic, view, device)
        if any(ctx.needs_input_grad):
            # Saving the tensors lets autograd notice parameters or pictures that were changed in place since.
            ctx.save_for_backward(*(p for p in pictures if p is not None), *tensors)
            ctx.set_materialize_grads(False)
            ctx.drawn, ctx.view, ctx.static_fields = drawn, view, n
        return pictures.rgb, pictures.alpha, pictures.depth

    @staticmethod
    def backward(
        ctx: Any, grad_rgb: Tensor | None, grad_alpha: Tensor | None, grad_depth: Tensor | None
    ) -> tuple[Tensor | None, ...]:
        n, view = ctx.static_fields, ctx.view
        shown = 3 if view.depth else 2
        pictures, tensors = Render(*ctx.saved_tensors[:shown]), ctx.saved_tensors[shown:]
        wanted = [
            torch.empty_like(tensor) if needed else None
            for tensor, needed in zip(tensors, ctx.needs_input_grad[3:], strict=True)
        ]
        with launching_on(pictures.rgb.device):
            differentiate(
                ctx.drawn,
                pictures,
                StaticSplats(*tensors[:n]) if n else None,
                DynamicSplats(*tensors[n:]) if tensors[n:] else None,
                torch.zeros_like(pictures.rgb) if grad_rgb is None else grad_rgb.contiguous(),
                None if grad_alpha is None else grad_alpha.contiguous(),
                None if grad_depth is None else grad_depth.contiguous(),
                StaticSplats(*wanted[:n]) if n else None,
                DynamicSplats(*wanted[n:]) if wanted[n:] else None,
                view.statistics,
                view.antialiased,
            )
        return None, None, None, *wanted
