"""The splats that live at a moment: a step draws and changes these alone."""

from __future__ import annotations

import math

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import logsigmoid

from hgs_core.render.constants import ALPHA_MIN, TIME_LOG_PRECISION_MAX
from hgs_core.scene.splats import DynamicSplats

__all__ = ["living_rows", "rows_taken"]

_SLACK = 0.01  # allowance for rounding, in the logarithm of the least drawn opacity


def living_rows(dynamic: DynamicSplats[Tensor], moment: float) -> Tensor:
    """Return the rows [R] int64, ascending, of all splats that can be drawn at normalised time `moment`.

    A splat whose opacity is below 1/255 then is drawn nowhere, and no picture of that moment can pull at it.
    """
    most = _SLACK - math.log(ALPHA_MIN)  # largest fading, in the logarithm of an opacity
    precisions = dynamic.time_log_precisions.detach().clamp(max=TIME_LOG_PRECISION_MAX).exp()
    faded = precisions * (moment - dynamic.time_centers.detach()).square()
    near = _places(faded <= most)  # few of them: the rest is looked at of these alone
    opacities = logsigmoid(dynamic.opacity_logits.detach()[near])
    return near[_places(faded[near] <= most + opacities)]


def _places(chosen: Tensor) -> Tensor:
    """Return where [N] is true, ascending; numpy takes a third of torch's time."""
    if chosen.device.type == "cpu":
        return torch.from_numpy(np.flatnonzero(chosen.numpy()))
    return torch.nonzero(chosen)[:, 0]


def rows_taken(dynamic: DynamicSplats[Tensor], rows: Tensor) -> DynamicSplats[Tensor]:
    """Return copies of the rows [R]; many times as fast as indexing."""
    return dynamic.map(lambda array: array.index_select(0, rows))
