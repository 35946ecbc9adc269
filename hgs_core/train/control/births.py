"""Rounds of births: dynamic splats where and when something moves that the scene does not show yet.

Density control multiplies splats that exist; what lives shorter than the gap between two initialised moments, or was
missed there, has none. So the scene is drawn at many moments, and moving pixels that are wrong are swept for points.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import torch

from hgs_core.base.cores import core_pool
from hgs_core.points.sweep import depth_ranges
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.camera import Camera
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.ghosts import visible_where_still, with_lives_shortened
from hgs_core.train.control.missing_points import MissingPoints, chosen_points, find_missing_points, picture_error
from hgs_core.train.control.round import RoundContext, is_after_share
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.splat_sets import kept, rows_of
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import Instant

__all__ = ["BIRTHS_AT", "BirthRound"]

BIRTHS_AT = (0.3, 0.45)
"""Shares of the iterations after which splats are born."""

_MOST_INSTANTS = 30  # instants of the segment in a round
_OPACITY = 0.6


@dataclass(frozen=True)
class BirthRound:
    """Adds dynamic splats where moving pixels are wrong, all over the segment, in half of the room that is left.

    Before, the lives of those there are end where still pixels are wrong. There must be masks.
    """

    name: ClassVar[str] = "births"
    on_host: ClassVar[bool] = True
    is_long: ClassVar[bool] = True
    config: TrainConfig

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        return is_after_share(self.config, iteration, BIRTHS_AT[: self.config.density.birth_rounds])

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        config, views, segment = self.config, context.views, context.segment
        generator = context.random(5)
        instants = min(_MOST_INSTANTS, segment.frames)
        most = max(0, context.schedule.splat_budgets[1] - len(state.dynamic)) // 2
        known = torch.cat([state.static.means, state.dynamic.motion[:, 0]]).numpy()
        ranges = depth_ranges(views.cameras, known)
        missing, moments, ghosts = [], [], []
        for instant in views.instants(instants, context.size, generator):
            with core_pool() as pool:
                errors = list(pool.map(partial(_error, state, config, instant), instant.cameras, instant.pictures))
            moments.append(instant.moment)
            ghosts.append(visible_where_still(state.dynamic, instant.cameras, instant.moment, instant.moving, errors))
            if most == 0:
                continue
            near = [ranges[place] for place in instant.places]
            found = find_missing_points(instant.cameras, instant.pictures, instant.moving, errors, near)
            count = len(found.points)
            alive, moving = np.full(count, instant.seconds, np.float32), np.ones(count, np.float32)
            missing.append(MissingPoints(dataclasses.replace(found.points, times=alive, dynamic=moving), found.urgency))
        shortened, changed = with_lives_shortened(state.dynamic, np.array(moments), np.stack(ghosts))
        dynamic = kept(state.dynamic, state.dynamic_optimiser, ~changed, shortened.take(rows_of(changed)))
        # They live for about a frame: what lives longer will learn to. So few iterations show them that they start
        # opaque.
        points = chosen_points(missing, most, generator)
        _, born = initial_splats(
            points, segment.clock, segment.frames, opacity=_OPACITY, coefficients=dynamic.motion.shape[1]
        )
        state.replace(state.static, kept(dynamic, state.dynamic_optimiser, None, born))
        state.history.births += len(born)


def _error(
    state: TrainState, config: TrainConfig, instant: Instant, camera: Camera, picture: npt.NDArray[np.uint8]
) -> npt.NDArray[np.float32]:
    """Return the error [H, W] of the instant's picture of a camera, levels of 255.

    Nothing is kept for the camera's next picture: the projected statics of a rig are most of the memory of a training.
    """
    drawn = rasterize(
        state.static,
        state.dynamic,
        camera,
        instant.moment,
        backend=config.backend,
        gradients="none",
        antialiased=config.antialiased,
    ).rgb
    return picture_error(drawn, picture)
