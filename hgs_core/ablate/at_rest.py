"""Static splats stored as dynamic ones that never move: what it costs not to share parameters over time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, StaticSplats

__all__ = ["with_statics_at_rest"]

_STEADY = -20.0  # ln s: at the ends of its segment such a splat has lost less than float32 can tell

Floats = npt.NDArray[np.float32]


def with_statics_at_rest(scene: HybridScene[Floats]) -> HybridScene[Floats]:
    """Return a scene that looks the same and has no statics: every segment has a copy of them in its dynamic set.

    The copies stand at the middle of their segment, have no velocity and neither turn nor fade.
    """
    segments = tuple(Segment(s.start, s.end, _joined(_at_rest(scene.static), s.dynamic)) for s in scene.segments)
    return HybridScene(StaticSplats.empty(), segments)


def _at_rest(static: StaticSplats[Floats]) -> DynamicSplats[Floats]:
    count = len(static)
    motion = np.zeros((count, 4, 3), np.float32)
    motion[:, 0] = static.means
    rotation = np.stack([static.quats, np.zeros_like(static.quats)], axis=1)
    return DynamicSplats(
        motion, rotation, static.log_scales, static.opacity_logits,
        np.full(count, 0.5, np.float32), np.full(count, _STEADY, np.float32), static.rgb,
    )  # fmt: skip


def _joined(first: DynamicSplats[Floats], second: DynamicSplats[Floats]) -> DynamicSplats[Floats]:
    pairs = zip(first.items(), second.items(), strict=True)
    return DynamicSplats(*(np.concatenate([a, b]) for (_, a), (_, b) in pairs))
