"""The compiled backend: float32 on the CPU, the C++ kernels behind autograd."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import torch
from torch import Tensor

from hgs_core.native.arrays import Floats
from hgs_core.native.raster import Raster
from hgs_core.render.types import Render, View
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["rasterize_cpu"]


def rasterize_cpu(static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View) -> Render:
    """Render as `hgs_core.render.rasterize` describes; parameters of another type are computed in float32.

    Raises:
        ValueError: an array of the wrong shape.
        RuntimeError: no compiled library, or more than 2^31 - 1 pairs of splats and tiles.
        MemoryError: not enough memory for them.
    """
    static_tensors = _prepared(static, view.gradients in ("all", "static"))
    dynamic_tensors = _prepared(dynamic, view.gradients in ("all", "dynamic"))
    arrays = (view, len(static_tensors), *static_tensors, *dynamic_tensors)
    rgb, alpha = _Rasterize.apply(*arrays)  # type: ignore[no-untyped-call]
    return Render(rgb, alpha)


def _prepared(splats: StaticSplats[Tensor] | DynamicSplats[Tensor] | None, wanted: bool) -> list[Tensor]:
    """Return the fields as contiguous float32 tensors, cut off from autograd if no gradient is wanted."""
    if splats is None:
        return []
    arrays = [array if wanted else array.detach() for _, array in splats.items()]
    return [array.to("cpu", torch.float32).contiguous() for array in arrays]


def _array(tensor: Tensor) -> Floats:
    array: Floats = tensor.detach().numpy()
    return array


class _Rasterize(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, view: View, n: int, *tensors: Tensor) -> tuple[Tensor, Tensor]:
        arrays = [_array(tensor) for tensor in tensors]  # the first n: all fields of the static set, or none
        raster = Raster(
            StaticSplats(*arrays[:n]) if n else None,
            DynamicSplats(*arrays[n:]) if arrays[n:] else None,
            view.camera,
            view.time,
            background=view.background,
            tile_mask=None if view.tile_mask is None else np.ascontiguousarray(view.tile_mask, np.bool_),
        )
        rgb, alpha = torch.from_numpy(raster.rgb), torch.from_numpy(raster.alpha)
        if any(ctx.needs_input_grad):
            # Saving the tensors lets autograd notice parameters or pictures that were changed in place since.
            ctx.save_for_backward(rgb, alpha, *tensors)
            ctx.set_materialize_grads(False)
            ctx.statistics, ctx.raster, ctx.static_fields = view.statistics, raster, n
        else:
            raster.release()
        return rgb, alpha

    @staticmethod
    def backward(ctx: Any, grad_rgb: Tensor | None, grad_alpha: Tensor | None) -> tuple[Tensor | None, ...]:
        _, _, *tensors = ctx.saved_tensors
        statistics, raster, n = ctx.statistics, ctx.raster, ctx.static_fields
        if grad_rgb is None:
            grad_rgb = torch.zeros(raster.rgb.shape)
        wanted = [
            torch.empty_like(tensor) if needed else None
            for tensor, needed in zip(tensors, ctx.needs_input_grad[2:], strict=True)
        ]
        gathered = None
        if statistics is not None:
            radii = np.zeros_like(statistics.grad_norm_sum)
            gathered = (statistics.grad_norm_sum, statistics.count, radii)
        raster.backward(
            _array(grad_rgb.contiguous()),
            None if grad_alpha is None else _array(grad_alpha.contiguous()),
            _named(StaticSplats, wanted[:n]),
            _named(DynamicSplats, wanted[n:]),
            gathered,
        )
        return None, None, *wanted


def _named(kind: type, tensors: list[Tensor | None]) -> dict[str, Floats] | None:
    """Return field name -> array of the gradients that are wanted, or None if there are none in this set."""
    names = [field.name for field in dataclasses.fields(kind)]
    arrays = {name: _array(tensor) for name, tensor in zip(names, tensors, strict=False) if tensor is not None}
    return arrays or None
