"""The compiled backend: float32 on the CPU, the C++ kernels behind autograd."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.camera import Camera
from hgs_core.native.arrays import Floats
from hgs_core.native.raster import Raster
from hgs_core.render.types import Render, ScreenStatistics
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["rasterize_cpu"]


def rasterize_cpu(
    static: StaticSplats[Tensor] | None,
    dynamic: DynamicSplats[Tensor] | None,
    camera: Camera,
    time: float = 0.0,
    *,
    background: Sequence[float] = (0.0, 0.0, 0.0),
    gradients: str = "all",
    tile_mask: npt.NDArray[np.bool_] | None = None,
    statistics: ScreenStatistics | None = None,
) -> Render:
    """Render as `hgs_core.render.rasterize` describes; parameters of another type are computed in float32.

    Raises:
        ValueError: an array of the wrong shape.
        RuntimeError: no compiled library, or more than 2^31 - 1 pairs of splats and tiles.
        MemoryError: not enough memory for them.
    """
    static_tensors = _prepared(static, gradients in ("all", "static"))
    dynamic_tensors = _prepared(dynamic, gradients in ("all", "dynamic"))
    red, green, blue = background
    mask = None if tile_mask is None else np.ascontiguousarray(tile_mask, np.bool_)
    view = _View(camera, time, (red, green, blue), mask, statistics, len(static_tensors))
    rgb, alpha = _Rasterize.apply(view, *static_tensors, *dynamic_tensors)  # type: ignore[no-untyped-call]
    return Render(rgb, alpha)


@dataclass(frozen=True)
class _View:
    """What the kernels need to know besides the parameters."""

    camera: Camera
    time: float
    background: tuple[float, float, float]
    tile_mask: npt.NDArray[np.bool_] | None
    statistics: ScreenStatistics | None
    static_fields: int  # how many of the tensors belong to the static set: all of its fields, or none


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
    def forward(ctx: Any, view: _View, *tensors: Tensor) -> tuple[Tensor, Tensor]:
        arrays = [_array(tensor) for tensor in tensors]
        n = view.static_fields
        raster = Raster(
            StaticSplats(*arrays[:n]) if n else None,
            DynamicSplats(*arrays[n:]) if arrays[n:] else None,
            view.camera,
            view.time,
            background=view.background,
            tile_mask=view.tile_mask,
        )
        rgb, alpha = torch.from_numpy(raster.rgb), torch.from_numpy(raster.alpha)
        if any(ctx.needs_input_grad):
            # Saving the tensors lets autograd notice parameters or pictures that were changed in place since.
            ctx.save_for_backward(rgb, alpha, *tensors)
            ctx.set_materialize_grads(False)
            ctx.view, ctx.raster = view, raster
        else:
            raster.release()
        return rgb, alpha

    @staticmethod
    def backward(ctx: Any, grad_rgb: Tensor | None, grad_alpha: Tensor | None) -> tuple[Tensor | None, ...]:
        _, _, *tensors = ctx.saved_tensors
        view, raster = ctx.view, ctx.raster
        if grad_rgb is None:
            grad_rgb = torch.zeros(raster.rgb.shape)
        n = view.static_fields
        wanted = [
            torch.empty_like(tensor) if needed else None
            for tensor, needed in zip(tensors, ctx.needs_input_grad[1:], strict=True)
        ]
        statistics = view.statistics
        raster.backward(
            _array(grad_rgb.contiguous()),
            None if grad_alpha is None else _array(grad_alpha.contiguous()),
            _named(StaticSplats, wanted[:n]),
            _named(DynamicSplats, wanted[n:]),
            None if statistics is None else (statistics.grad_norm_sum, statistics.count, statistics.max_radius),
        )
        return None, *wanted


def _named(kind: type, tensors: list[Tensor | None]) -> dict[str, Floats] | None:
    """Return field name -> array of the gradients that are wanted, or None if there are none in this set."""
    names = [field.name for field in dataclasses.fields(kind)]
    arrays = {name: _array(tensor) for name, tensor in zip(names, tensors, strict=False) if tensor is not None}
    return arrays or None
