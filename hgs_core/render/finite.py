"""Refusal of parameters that no picture can show (docs/numerics.md)."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.render.constants import COLOUR_MAX
from hgs_core.render.moment import alive
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["refuse_non_finite"]

_LIFE = ("opacity_logits", "time_centers", "time_log_precisions")  # parameters of a dynamic splat's life


def refuse_non_finite(static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, time: float) -> None:
    """Refuse splats with a NaN, an infinity or a colour beyond 1e18 where a picture at normalised `time` uses them.

    Of statics that is every parameter; of dynamics opacity, centre and precision of all, and the other parameters of
    those that are alive at `time`.

    Raises:
        InputError: names the set, the field, the row and the value of the first one.
    """
    if static is not None:
        for name, array in static.items():
            _refuse("static splats", name, array, None)
    if dynamic is not None:
        for name in _LIFE:
            _refuse("dynamic splats", name, getattr(dynamic, name), None)
        living = alive(dynamic, time)
        for name, array in dynamic.items():
            if name not in _LIFE:
                _refuse("dynamic splats", name, array, living)


def _refuse(where: str, name: str, array: Tensor, looked_at: Tensor | None) -> None:
    with torch.no_grad():
        # Written so that a NaN fails.
        fine = array.abs() <= COLOUR_MAX if name == "rgb" else torch.isfinite(array)
        broken = ~fine.flatten(1).all(1) if array.dim() > 1 else ~fine
        if looked_at is not None:
            broken &= looked_at
        if not broken.any():
            return
        row = int(torch.nonzero(broken)[0])
        value = array[row].flatten()[~fine[row].flatten()][0].item()
        if math.isfinite(value):
            raise InputError(where, f"{name}[{row}] is {value:g}", f"give it a colour within {COLOUR_MAX:g}")
        raise InputError(where, f"{name}[{row}] is {value}", "remove the splat or give it finite parameters")
