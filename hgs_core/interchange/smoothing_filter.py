"""The 3D smoothing filter of Mip-Splatting (Yu et al., 2024): a width for each splat that its renderer adds.

Fused with it, as the trainer's own export for other viewers does, scales and opacities are plain ones: variances grow
by the filter's square, and opacities fall by the square root of how much the determinant grows.
"""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.interchange.changes import Action, Change
from hgs_core.scene.opacities import logits_of_any, opacities_of

__all__ = ["FILTER", "fused", "widened"]

FILTER = "filter_3D"


def widened(log_scales: Doubles, widths: Doubles) -> Doubles:
    """Return log-scales [N, 3] with variances larger by the squares of widths [N], world units."""
    with np.errstate(divide="ignore"):
        return np.asarray(np.logaddexp(2 * log_scales, 2 * np.log(np.abs(widths))[:, None]) / 2)


def fused(log_scales: Floats, logits: Floats, widths: Doubles) -> tuple[Floats, Floats, Change]:
    """Return log-scales [N, 3] and logits [N] with filters of some widths [N], world units, applied to them."""
    scales = log_scales.astype(np.float64)
    wider = widened(scales, widths)
    shares = np.exp((scales - wider).sum(axis=1))
    met = np.isfinite(widths) & (widths != 0)
    opacity = logits_of_any(np.where(np.isnan(logits), np.nan, opacities_of(logits) * shares))
    reason = f"by those that the column {FILTER} of Mip-Splatting makes of them"
    change = Change.where(Action.REPLACED, "scale and opacity", met, reason)
    return (
        np.where(met[:, None], wider, log_scales).astype(np.float32),
        np.where(met, opacity, logits).astype(np.float32),
        change,
    )
