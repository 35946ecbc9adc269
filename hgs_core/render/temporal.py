"""The equations of time in torch: what a dynamic set looks like at one moment, differentiably."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.render.constants import ALPHA_MIN
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["Moment", "alive", "moment_of_dynamic", "moment_of_static"]


@dataclass(frozen=True)
class Moment:
    """K splats at one moment, ready for projection."""

    means: Tensor  # [K, 3]
    log_scales: Tensor  # [K, 3]
    quats: Tensor  # [K, 4] w, x, y, z, not normalised
    opacities: Tensor  # [K] in [0, 1]
    rgb: Tensor  # [K, 3]


def moment_of_static(splats: StaticSplats[Tensor]) -> Moment:
    """Return static splats as they always are."""
    return Moment(
        splats.means, splats.log_scales, splats.quats, torch.sigmoid(splats.opacity_logits), splats.rgb
    )  # fmt: skip


def alive(splats: DynamicSplats[Tensor], time: float) -> Tensor:
    """Return which splats [M] have an opacity of at least 1/255 at normalised `time` (exact culling)."""
    with torch.no_grad():
        offset = time - splats.time_centers
        decay = torch.exp(splats.time_log_precisions) * offset * offset
        return torch.sigmoid(splats.opacity_logits) * torch.exp(-decay) >= ALPHA_MIN


def moment_of_dynamic(splats: DynamicSplats[Tensor], time: float) -> Moment:
    """Evaluate dynamic splats at normalised `time` (docs/numerics.md, "Time")."""
    d = (time - splats.time_centers)[:, None]
    m = splats.motion
    means = m[:, 0] + d * (m[:, 1] + d * (m[:, 2] + d * m[:, 3]))
    quats = splats.rotation[:, 0] + d * splats.rotation[:, 1]
    decay = torch.exp(-torch.exp(splats.time_log_precisions) * d[:, 0] * d[:, 0])
    opacities = torch.sigmoid(splats.opacity_logits) * decay
    return Moment(means, splats.log_scales, quats, opacities, splats.rgb)
