"""The equations of time in torch: a dynamic set at one moment, differentiably.

Parameters of any type are evaluated in float64: this costs little beside the pixels, and a position far from the origin
keeps the digits that its place on the screen needs.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.render.constants import ALPHA_MIN, TIME_LOG_PRECISION_MAX
from hgs_core.scene.motion import position
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["Moment", "alive", "moment_of_dynamic", "moment_of_static"]


@dataclass(frozen=True)
class Moment:
    """K splats at one moment in float64, ready for projection."""

    means: Tensor  # [K, 3]
    log_scales: Tensor  # [K, 3]
    quats: Tensor  # [K, 4] w, x, y, z, not normalised
    opacities: Tensor  # [K] in [0, 1]
    rgb: Tensor  # [K, 3]


def moment_of_static(splats: StaticSplats[Tensor]) -> Moment:
    """Return static splats as they always are."""
    s = splats.map(Tensor.double)
    return Moment(s.means, s.log_scales, s.quats, torch.sigmoid(s.opacity_logits), s.rgb)


def alive(splats: DynamicSplats[Tensor], time: float) -> Tensor:
    """Return which splats [M] have an opacity of at least 1/255 at normalised `time` (exact culling)."""
    with torch.no_grad():
        offsets = time - splats.time_centers.double()
        return _opacities(splats.opacity_logits.double(), splats.time_log_precisions.double(), offsets) >= ALPHA_MIN


def moment_of_dynamic(splats: DynamicSplats[Tensor], time: float) -> Moment:
    """Evaluate dynamic splats at normalised `time` (docs/numerics.md, "Time")."""
    s = splats.map(Tensor.double)
    offsets = time - s.time_centers
    d = offsets[:, None]
    means = position(s.motion, d)
    quats = s.rotation[:, 0] + d * s.rotation[:, 1]
    opacities = _opacities(s.opacity_logits, s.time_log_precisions, offsets)
    return Moment(means, s.log_scales, quats, opacities, s.rgb)


def _opacities(logits: Tensor, log_precisions: Tensor, offsets: Tensor) -> Tensor:
    decay = torch.exp(log_precisions.clamp_max(TIME_LOG_PRECISION_MAX)) * offsets * offsets
    return torch.sigmoid(logits) * torch.exp(-decay)
