"""Pruning of splats that no training view needs, of fog, and of splats outside the hull of motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from hgs_core.base.bounded_map import bounded_map
from hgs_core.base.cores import core_pool
from hgs_core.render.fixed_view import FixedView
from hgs_core.scene.camera import Camera
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.births import BIRTHS_AT
from hgs_core.train.control.density import is_fog
from hgs_core.train.control.hull import outside_moving_hull
from hgs_core.train.control.round import RoundContext, is_after_share
from hgs_core.train.splat_sets import kept
from hgs_core.train.train_config import TrainConfig

__all__ = ["PruningRound"]

_PRUNED_AT = (*BIRTHS_AT, 0.65, 0.85)  # shares of the iterations; before births, to make room
_MOMENTS = 60  # most moments of the segment for blending weights
_FRAMES_APART = 2  # the briefest splat, gone by half in half a frame, still has a sixteenth a frame on


@dataclass(frozen=True)
class PruningRound:
    """The round that removes splats with too small a blending weight in every pixel of every training view.

    So are dynamic splats that are fog, or that have left the hull of what moves.
    """

    name: ClassVar[str] = "pruning"
    on_host: ClassVar[bool] = True
    is_long: ClassVar[bool] = True
    config: TrainConfig

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        return self.config.density.prune_contribution > 0 and is_after_share(self.config, iteration, _PRUNED_AT)

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        config, views, statics = self.config, context.views, len(state.static)
        frames, extent = context.segment.frames, context.schedule.extent
        peak = np.zeros(statics + len(state.dynamic), np.float32)

        def seen(pose: tuple[Camera, Sequence[float]]) -> npt.NDArray[np.float32]:
            camera, moments = pose
            fixed = FixedView(state.static, camera, antialiased=config.antialiased, backend=config.backend)
            largest = np.zeros(statics + len(state.dynamic), np.float32)
            for moment in moments:
                np.maximum(largest, fixed.contributions(state.dynamic, moment).peak, out=largest)
            return largest

        with core_pool() as pool:
            poses = views.poses(min(_MOMENTS, -(-frames // _FRAMES_APART)))
            for largest in bounded_map(pool, seen, poses):
                np.maximum(peak, largest, out=peak)
        needed = peak >= config.density.prune_contribution
        needed[statics:] &= ~is_fog(state.dynamic, extent, config).numpy()
        if views.masked:
            needed[statics:] &= ~outside_moving_hull(state.dynamic, views.cameras, frames, views.moving)
        static = state.static
        if context.statics_learn:
            static = kept(static, state.static_optimiser, needed[:statics])
        state.replace(static, kept(state.dynamic, state.dynamic_optimiser, needed[statics:]))
        state.history.pruned += len(peak) - len(state.static) - len(state.dynamic)
