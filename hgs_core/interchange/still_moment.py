"""A scene as it stands at one moment."""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Floats
from hgs_core.scene.opacities import logits_of
from hgs_core.scene.splats import HybridScene, StaticSplats, joined
from hgs_core.scene.temporal import evaluate

__all__ = ["scene_at"]

LEAST_OPACITY = 1 / 255  # below it no pixel shows


def scene_at(scene: HybridScene[Floats], seconds: float) -> StaticSplats[Floats]:
    """Return the splats that can be seen at a moment, as static ones: the scene's statics first."""
    segment = scene.segment_at(seconds)
    positions, quats, opacities = evaluate(segment.dynamic, segment.normalised(seconds))
    alive = opacities >= LEAST_OPACITY
    sigma = np.minimum(opacities[alive], 1 - 1e-7)
    living = StaticSplats(
        positions[alive].astype(np.float32),
        segment.dynamic.log_scales[alive],
        quats[alive].astype(np.float32),
        logits_of(sigma),
        segment.dynamic.rgb[alive],
    )
    return joined([scene.static, living])
