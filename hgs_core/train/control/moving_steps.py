"""Further steps where it moves: of the dynamics alone, in the tiles where something moves.

What stands still is seen in every picture of a camera, what moves in the few that show it there. Drawing a moving tile
again costs a fraction of a picture, and the statics of the fixed cameras need to be projected and sorted once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from torch import Tensor

from hgs_core.render.fixed_view import FixedView
from hgs_core.render.types import ScreenStatistics
from hgs_core.scene.splats import DynamicSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.round import RoundContext
from hgs_core.train.moving_tiles import MovingTiles, loss_gradient
from hgs_core.train.splats_alive import living_rows, rows_taken
from hgs_core.train.train_config import MOVING_FROM, TrainConfig
from hgs_core.train.training_views import TrainingView

__all__ = ["MovingSteps", "step_of_movers"]

_EVERY = 100  # iterations, after which as many times `train.moving_steps` are taken with the statics as they are


@dataclass(frozen=True)
class MovingSteps:
    """Takes steps of the dynamics in the tiles that the masks mark; statics and colour maps stay as they are."""

    name: ClassVar[str] = "moving steps"
    on_host: ClassVar[bool] = False
    is_long: ClassVar[bool] = False
    config: TrainConfig

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        done = iteration + 1
        return done % _EVERY == 0 and done > MOVING_FROM * self.config.iterations

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        count = round(_EVERY * self.config.moving_steps)
        cameras: dict[int, FixedView] = {}
        for view, moving in context.views.where_it_moves(context.iteration, count, context.size):
            if view.place not in cameras:
                cameras[view.place] = FixedView(
                    state.static, view.camera, antialiased=self.config.antialiased, backend=self.config.backend
                )
            self._step(state, context, cameras[view.place], view, moving)

    def _step(
        self, state: TrainState, context: RoundContext, fixed: FixedView, view: TrainingView, moving: MovingTiles
    ) -> None:
        def draw(living: DynamicSplats[Tensor], seen: ScreenStatistics | None) -> Tensor:
            return fixed.differentiable_frame(living, view.moment, tile_mask=moving.tiles, statistics=seen).rgb

        step_of_movers(state, context, self.config, view, moving, view.target, draw, statics=len(state.static))


def step_of_movers(
    state: TrainState,
    context: RoundContext,
    config: TrainConfig,
    view: TrainingView,
    moving: MovingTiles,
    target: Tensor,
    draw: Callable[[DynamicSplats[Tensor], ScreenStatistics | None], Tensor],
    *,
    statics: int = 0,
) -> None:
    """Take one step of the living dynamics towards a window's target; nothing without any.

    Args:
        state: changed in place; statics and colour maps stay as they are.
        context: of the round.
        config: of the run.
        view: the view.
        moving: its tiles that are drawn.
        target: [3, h, w] of their window.
        draw: gives the picture [3, H, W] of living dynamics, and counts pulls at them where density control needs any.
        statics: splats that are drawn and counted before them.
    """
    rows = living_rows(state.dynamic, view.moment)
    if not len(rows):
        return
    living = rows_taken(state.dynamic, rows)
    living.map(lambda array: array.requires_grad_(True))
    seen = ScreenStatistics.zeros(statics + len(rows))
    picture = draw(living, seen if context.schedule.are_pulls_counted(context.iteration) else None)
    gradient = loss_gradient(picture.detach(), target, view.camera, moving, config.dssim, state.colours(view))
    picture.backward(gradient)  # type: ignore[no-untyped-call]
    living.map(lambda array: array.requires_grad_(False))
    if state.time_shifts is not None and context.statics_learn:
        state.time_shifts.step(view.place, living, context.schedule.time_shift_rate(context.iteration))
    rates = context.schedule.dynamic_rates(context.iteration, living)
    seen = seen.rows(slice(statics, None))
    state.move_dynamic(living, rows, rates, seen, config.density.dynamic_opacity_penalty)
    state.dynamic.rgb.clamp_(0, 1)
