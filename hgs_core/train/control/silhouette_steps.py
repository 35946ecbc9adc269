"""Steps of movers that are drawn alone, over colours drawn at random: opaque where masks say so, and nowhere else.

Where cameras stand far apart, a mover that is half transparent, with its own colours painted on the room behind it,
looks right in every training picture and in no other. Over a random colour only what covers it looks right. Once movers
are opaque, long trainings learn their edges and colours over the room.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import torch
from torch import Tensor

from hgs_core.render.rasterize import rasterize
from hgs_core.render.types import ScreenStatistics
from hgs_core.scene.splats import DynamicSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.moving_steps import step_of_movers
from hgs_core.train.control.round import RoundContext
from hgs_core.train.moving_tiles import MovingTiles
from hgs_core.train.train_config import MOVING_FROM, TrainConfig
from hgs_core.train.training_views import TrainingView

__all__ = ["SilhouetteSteps"]


@dataclass(frozen=True)
class SilhouetteSteps:
    """Takes the dynamics' step of an iteration, and the config's further ones, until those over the room begin."""

    name: ClassVar[str] = "silhouettes"
    on_host: ClassVar[bool] = False
    is_long: ClassVar[bool] = False
    config: TrainConfig
    throughout: bool  # whether steps over the room never take their place

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        return self.throughout or iteration + 1 <= MOVING_FROM * self.config.iterations

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place; statics and colour maps stay as they are."""
        random, more = context.random(8), round(self.config.moving_steps)
        for view, moving in context.views.silhouettes(context.iteration, more, context.size):
            red, green, blue = (float(one) for one in random.random(3))
            self._step(state, context, view, moving, (red, green, blue))

    def _step(
        self,
        state: TrainState,
        context: RoundContext,
        view: TrainingView,
        moving: MovingTiles,
        behind: tuple[float, float, float],
    ) -> None:
        def draw(living: DynamicSplats[Tensor], seen: ScreenStatistics | None) -> Tensor:
            return rasterize(
                None,
                living,
                view.camera,
                view.moment,
                background=behind,
                backend=self.config.backend,
                tile_mask=moving.tiles,
                statistics=seen,
                antialiased=self.config.antialiased,
            ).rgb

        colours = state.colours(view)
        still = torch.tensor(behind)[:, None, None].to(view.target.device).expand_as(view.target)
        if colours is not None:
            still = colours.shown(still.contiguous(), view.camera, moving.window)
        assert view.moving is not None
        target = torch.where(view.moving, view.target, still)
        step_of_movers(state, context, self.config, view, moving, target, draw)
