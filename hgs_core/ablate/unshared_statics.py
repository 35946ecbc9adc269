"""Static splats stored as dynamic ones that never move: the cost of parameters that are not shared over time."""

from __future__ import annotations

import dataclasses

from hgs_core.base.arrays import Floats
from hgs_core.scene.at_rest import at_rest
from hgs_core.scene.splats import HybridScene, Segment, StaticSplats, joined

__all__ = ["with_statics_at_rest"]


def with_statics_at_rest(scene: HybridScene[Floats]) -> HybridScene[Floats]:
    """Return a scene that looks the same and has no statics: every segment has a copy of them in its dynamic set.

    The copies stand at the middle of their segment, have no velocity and neither turn nor fade.
    """
    segments = tuple(Segment(s.start, s.end, joined([at_rest(scene.static), s.dynamic])) for s in scene.segments)
    return dataclasses.replace(scene, static=StaticSplats.empty(), segments=segments)
