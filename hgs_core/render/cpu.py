"""The compiled backend: float32 on the CPU, the C++ kernels behind autograd."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.native.kernel_arrays import Floats
from hgs_core.native.raster import Raster
from hgs_core.render.finite import refuse_non_finite
from hgs_core.render.magnification import magnification
from hgs_core.render.types import Contributions, Render, ScreenStatistics, View
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["FixedViewCpu", "contributions_cpu", "rasterize_cpu"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])


def rasterize_cpu(static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View) -> Render:
    """Render as `hgs_core.render.rasterize` describes; parameters of another type are computed in float32.

    Raises:
        InputError: a parameter that is not finite.
        ValueError: an array of the wrong shape, or a picture of more than 65,535 pixels along a side.
        RuntimeError: no compiled library, or more than 2^31 - 1 pairs of splats and tiles.
        MemoryError: not enough memory for them.
    """
    static = _prepared(static, view.gradients in ("all", "static"))
    dynamic = _prepared(dynamic, view.gradients in ("all", "dynamic"))
    tensors = [array for splats in (static, dynamic) if splats is not None for _, array in splats.items()]
    with _non_finite_named(static, dynamic, view.time):
        picture = _Rasterize.apply(view, None, static is not None, *tensors)  # type: ignore[no-untyped-call]
    return Render(*picture)


def contributions_cpu(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View
) -> Contributions:
    """Weigh the splats as `hgs_core.render.contributions` describes; raises the errors of `rasterize_cpu`."""
    static, dynamic = _prepared(static, False), _prepared(dynamic, False)
    with _non_finite_named(static, dynamic, view.time):
        raster = _raster(_arrays(static), _arrays(dynamic), view, draw=False)
    weighed = Contributions(*raster.contributions())
    raster.release()
    return weighed


class FixedViewCpu:
    """Frames from one camera: the statics are projected and sorted for the first one only."""

    def __init__(self, static: StaticSplats[Tensor] | None, view: View) -> None:
        """Keep the state common to all frames; `view` has everything but the time and the wish for depth."""
        self._static, self._view = _prepared(static, False), view
        self._raster: Raster | None = None

    def frame(self, dynamic: DynamicSplats[Tensor] | None, time: float, depth: bool) -> Render:
        """Draw one moment; raises the errors of `rasterize_cpu`."""
        return Render(*_pictures(self._at(dynamic, time, depth=depth)))

    def differentiable_frame(
        self,
        dynamic: DynamicSplats[Tensor],
        time: float,
        tile_mask: npt.NDArray[np.bool_] | None,
        statistics: ScreenStatistics | None,
    ) -> Render:
        """Draw one moment, differentiable towards the dynamics until the next one is drawn."""
        prepared = _prepared(dynamic, True)
        assert prepared is not None
        view = dataclasses.replace(self._view, time=time, tile_mask=tile_mask, statistics=statistics)
        tensors = [array for _, array in prepared.items()]
        with _non_finite_named(self._static, prepared, time):
            return Render(*_Rasterize.apply(view, self, False, *tensors))  # type: ignore[no-untyped-call]

    def contributions(self, dynamic: DynamicSplats[Tensor] | None, time: float) -> Contributions:
        """Weigh the splats at one moment; raises the errors of `rasterize_cpu`."""
        return Contributions(*self._at(dynamic, time, draw=False).contributions())

    def _at(
        self, dynamic: DynamicSplats[Tensor] | None, time: float, *, depth: bool = False, draw: bool = True
    ) -> Raster:
        dynamic = _prepared(dynamic, False)
        view = dataclasses.replace(self._view, time=time, depth=depth)
        with _non_finite_named(self._static, dynamic, time):
            return self.rastered(_arrays(dynamic), view, draw=draw)

    def rastered(self, dynamic: DynamicSplats[Floats] | None, view: View, *, draw: bool = True) -> Raster:
        """Raster a view from this camera; the statics are projected and sorted for the first one only."""
        if self._raster is None:
            self._raster = _raster(_arrays(self._static), dynamic, view, keep_statics=True, draw=draw)
        else:
            self._raster.redraw(dynamic, view.time, view.depth, _mask(view), draw=draw)
        return self._raster


def _prepared(splats: S | None, wanted: bool) -> S | None:
    """Make the fields contiguous float32 tensors, cut off from autograd if no gradient is wanted."""
    if splats is None:
        return None
    return splats.map(lambda array: (array if wanted else array.detach()).to("cpu", torch.float32).contiguous())


def _array(tensor: Tensor) -> Floats:
    array: Floats = tensor.detach().numpy()
    return array


def _arrays(splats: Any) -> Any:
    """Return a set of tensors as a set of arrays."""
    return None if splats is None else splats.map(_array)


def _mask(view: View) -> npt.NDArray[np.bool_] | None:
    return None if view.tile_mask is None else np.ascontiguousarray(view.tile_mask, np.bool_)


def _raster(
    static: StaticSplats[Floats] | None,
    dynamic: DynamicSplats[Floats] | None,
    view: View,
    *,
    keep_statics: bool = False,
    draw: bool = True,
) -> Raster:
    return Raster(
        static,
        dynamic,
        view.camera,
        view.time,
        background=view.background,
        tile_mask=_mask(view),
        antialiased=view.antialiased,
        depth=view.depth,
        keep_statics=keep_statics,
        draw=draw,
        magnification=magnification(view.camera, view.rig),
    )


def _pictures(raster: Raster) -> tuple[Tensor, Tensor, Tensor | None]:
    depth = None if raster.depth is None else torch.from_numpy(raster.depth)
    return torch.from_numpy(raster.rgb), torch.from_numpy(raster.alpha), depth


@contextmanager
def _non_finite_named(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, time: float
) -> Iterator[None]:
    """Turn the kernels' complaint about some parameter into one that names it."""
    try:
        yield
    except FloatingPointError:
        refuse_non_finite(static, dynamic, time)
        raise


class _Rasterize(torch.autograd.Function):
    @staticmethod
    def forward(
        ctx: Any, view: View, fixed: FixedViewCpu | None, has_static: bool, *tensors: Tensor
    ) -> tuple[Tensor, Tensor, Tensor | None]:
        """Draw `tensors`, statics first if there are some; the statics of a fixed view are its own."""
        arrays = [_array(tensor) for tensor in tensors]
        n = len(dataclasses.fields(StaticSplats)) if has_static else 0
        static = StaticSplats(*arrays[:n]) if n else None
        dynamic = DynamicSplats(*arrays[n:]) if arrays[n:] else None
        raster = _raster(static, dynamic, view) if fixed is None else fixed.rastered(dynamic, view)
        pictures = _pictures(raster)
        if any(ctx.needs_input_grad):
            # Saving the tensors lets autograd notice parameters or pictures that were changed in place since.
            ctx.save_for_backward(*(p for p in pictures if p is not None), *tensors)
            ctx.set_materialize_grads(False)
            ctx.statistics, ctx.raster, ctx.static_fields = view.statistics, raster, n
        elif fixed is None:
            raster.release()
        return pictures

    @staticmethod
    def backward(
        ctx: Any, grad_rgb: Tensor | None, grad_alpha: Tensor | None, grad_depth: Tensor | None
    ) -> tuple[Tensor | None, ...]:
        statistics, raster, n = ctx.statistics, ctx.raster, ctx.static_fields
        tensors = ctx.saved_tensors[2 if raster.depth is None else 3 :]
        if grad_rgb is None:
            grad_rgb = torch.zeros(raster.rgb.shape)
        wanted = [
            torch.empty_like(tensor) if needed else None
            for tensor, needed in zip(tensors, ctx.needs_input_grad[3:], strict=True)
        ]
        raster.backward(
            _array(grad_rgb.contiguous()),
            None if grad_alpha is None else _array(grad_alpha.contiguous()),
            _named(StaticSplats, wanted[:n]),
            _named(DynamicSplats, wanted[n:]),
            None if statistics is None else (statistics.pull_sum, statistics.count),
            None if grad_depth is None else _array(grad_depth.contiguous()),
        )
        return None, None, None, *wanted


def _named(kind: type, tensors: list[Tensor | None]) -> dict[str, Floats] | None:
    """Return field name -> array of the gradients that are wanted, or None if there are none in this set."""
    names = [field.name for field in dataclasses.fields(kind)]
    arrays = {name: _array(tensor) for name, tensor in zip(names, tensors, strict=False) if tensor is not None}
    return arrays or None
