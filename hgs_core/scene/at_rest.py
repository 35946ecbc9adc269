"""Static splats as dynamic ones that never change."""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Floats
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["STEADY", "at_rest"]

STEADY = -20.0
"""ln s of a splat that has lost less at the ends of its segment than float32 can tell."""


def at_rest(static: StaticSplats[Floats]) -> DynamicSplats[Floats]:
    """Return the splats in the middle of a segment, without velocity; they neither turn nor fade."""
    count = len(static)
    motion = np.zeros((count, 4, 3), np.float32)
    motion[:, 0] = static.means
    rotation = np.stack([static.quats, np.zeros_like(static.quats)], axis=1)
    return DynamicSplats(
        motion,
        rotation,
        static.log_scales,
        static.opacity_logits,
        np.full(count, 0.5, np.float32),
        np.full(count, STEADY, np.float32),
        static.rgb,
    )
