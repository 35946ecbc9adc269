"""Gauss-Newton steps in the place of a trainer's, for `finishes.py`.

The momentum of the gradient is divided by the diagonal of J^T J plus a damping, J being the derivative of the pixels
that a step compares. Pixels are weighted by 0.8 / |error|, at most 40, so that the squares stand for the L1 loss. For
random signs v, (J^T v)^2 has this diagonal as its mean: before one step in eight, a picture is drawn and differentiated
for it. Steps of positions are limited to a share of the splat's size, all others to small values.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import torch
from torch import Tensor

from hgs_core.render.fixed_view import FixedView
from hgs_core.render.rasterize import rasterize
from hgs_core.render.types import WHOLE, Gradients, Window
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.colour_correction import CameraColours
from hgs_core.train.control.moving_steps import MovingSteps
from hgs_core.train.control.round import RoundContext
from hgs_core.train.moving_tiles import MovingTiles
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.splats_alive import living_rows, rows_taken
from hgs_core.train.trainer import Trainer
from hgs_core.train.training_views import TrainingView

__all__ = ["Newton", "NewtonSteps", "probed"]

Splats = StaticSplats[Tensor] | DynamicSplats[Tensor]

_PROBE_EVERY = 8  # steps; in every one until Gauss-Newton steps begin
_WARM = 0.17  # share of the finish after which they begin
_MOMENTUM, _MEMORY = 0.8, 200.0  # of gradients; visits over which the diagonal is a mean
_LEAST_ERROR = 0.02  # below which a pixel's weight does not grow
_TRUST = {
    "means": 0.1,
    "motion": 0.1,
    "log_scales": 0.05,
    "quats": 0.02,
    "rotation": 0.02,
    "opacity_logits": 0.1,
    "rgb": 0.01,
    "time_centers": 0.1,
    "time_log_precisions": 0.1,
}
"""Longest steps: of positions in sizes of the splat, of `time_centers` in lives."""


@dataclasses.dataclass(frozen=True)
class Newton:
    """How Gauss-Newton steps are taken: alpha times the momentum over diagonal plus damping, falling to 2 %."""

    alpha: float
    trust: float  # multiple of `_TRUST`
    damping_by_mean: bool = False  # over splats; else by the median
    damping: float = 1.0  # multiple of this


def probed(
    picture: Tensor,
    weights: Tensor,
    colours: CameraColours | None,
    camera: Camera,
    generator: torch.Generator,
    window: Window = WHOLE,
) -> None:
    """Leave J^T v in the `.grad` of what a window [3, H, W] of a picture was drawn from.

    The pixels of v are random signs times the root of `weights` [3, H, W]; J is that of the picture with its camera's
    colours, if these are known.
    """
    signs = torch.sign(torch.rand(weights.shape, generator=generator) - 0.5) * weights.sqrt()
    shown = picture if colours is None else colours.shown(picture, camera, window)
    shown.backward(signs)


class NewtonSteps:
    """Puts Gauss-Newton steps in the place of a trainer's."""

    def __init__(self, trainer: Trainer, how: Newton) -> None:
        self._how, self._generator, self._steps, self.on = how, torch.Generator().manual_seed(0), 0, False
        state, frames = trainer.state, trainer.segment.frames
        self.static = _GaussNewton(state.static_optimiser, frames, how)
        self.dynamic = _GaussNewton(state.dynamic_optimiser, frames, how)
        state.static_optimiser, state.dynamic_optimiser = self.static, self.dynamic
        self._state, self._trainer, self._learn = state, trainer, trainer._learn
        trainer._learn = self._whole  # type: ignore[method-assign]
        trainer.rounds = tuple(
            _ProbedMovingSteps(one.config, self) if isinstance(one, MovingSteps) else one for one in trainer.rounds
        )

    def follow(self, progress: float) -> None:
        """Set the steps for a share of the finish that is done."""
        if progress >= _WARM and not self.on:
            self.on = True
            self.static.begin()
            self.dynamic.begin()
        done = max(0.0, (progress - _WARM) / (1 - _WARM))
        share = 0.02 + 0.98 * 0.5 * (1 + math.cos(math.pi * done))
        self.static.share = self.dynamic.share = share

    def due(self) -> bool:
        """Return whether the next step takes a probe; counts it."""
        self._steps += 1
        return not self.on or self._steps % _PROBE_EVERY == 0

    def _whole(self, stage: Gradients, iteration: int, view: TrainingView, **rest: Any) -> None:
        if self.due():
            static, state = self._state.static, self._state
            rows = living_rows(state.dynamic, view.moment)
            living = rows_taken(state.dynamic, rows)
            for splats in (static, living):
                splats.map(lambda array: array.requires_grad_(True))
            config = self._trainer.config
            picture = rasterize(static, living, view.camera, view.moment, antialiased=config.antialiased).rgb
            self.probe(picture, view, None)
            self.static.learn(static, None)
            self.dynamic.learn(living, rows)
            static.map(lambda array: array.requires_grad_(False))
        self._learn(stage, iteration, view, **rest)

    def probe(self, picture: Tensor, view: TrainingView, moving: MovingTiles | None) -> None:
        """Leave J^T v of a view in the gradients; the pixels of `moving`, of which it has the target, alone count."""
        colours, window = self._state.colours(view), WHOLE if moving is None else moving.window
        part = picture if moving is None else moving.cut(picture)
        shown = part.detach() if colours is None else colours.shown(part.detach(), view.camera, window)
        weights = 0.8 / (shown - view.target).abs().clamp(min=_LEAST_ERROR) / picture.numel()
        weights = weights if moving is None else weights * moving.drawn()
        probed(part, weights, colours, view.camera, self._generator, window)


class _GaussNewton(RmsProp):
    """RMSprop until `begin`, Gauss-Newton steps from then on."""

    def __init__(self, inner: RmsProp, frames: int, how: Newton) -> None:
        super().__init__(inner.moments, inner.updated, inner.steps)
        self._frames, self._how, self.share = frames, how, 1.0
        self._diagonal, self._momentum = (inner.moments.map(torch.zeros_like) for _ in range(2))
        self._probes, self._visits = (torch.zeros(len(inner.updated)) for _ in range(2))
        self._damping: dict[str, Tensor] | None = None

    def to(self, device: torch.device) -> _GaussNewton:
        return self

    def learn(self, splats: Splats, rows: Tensor | None) -> None:
        """Take the gradients of `splats`, which are these rows, as a probe of the diagonal."""
        place = slice(None) if rows is None else rows
        self._probes[place] += 1
        for name, array in splats.items():
            mean, gradient = getattr(self._diagonal, name), array.grad
            share = 1 / self._probes[place].clamp(max=_MEMORY).reshape(-1, *[1] * (mean.dim() - 1))
            mean[place] += share * (gradient * gradient - mean[place])
            array.grad = None

    def begin(self) -> None:
        """Take Gauss-Newton steps from now on."""
        known = self._diagonal.map(lambda array: array[self._probes > 0])
        over = torch.Tensor.mean if self._how.damping_by_mean else _median
        self._damping = {name: self._how.damping * over(array, 0) + 1e-30 for name, array in known.items()}

    def step(
        self,
        splats: Splats,
        rates: Mapping[str, float | Tensor],
        shown: Splats | None = None,
        rows: Tensor | None = None,
    ) -> None:
        if self._damping is None:
            super().step(splats, rates, shown, rows)
            return
        place = slice(None) if rows is None else rows
        self._visits[place] += 1
        limits = self._limits(splats if rows is None else splats.take(rows))
        for name, array in splats.items():
            seen = getattr(splats if shown is None else shown, name)
            momentum, diagonal = getattr(self._momentum, name), getattr(self._diagonal, name)[place]
            momentum[place] = _MOMENTUM * momentum[place] + (1 - _MOMENTUM) * seen.grad
            unbiased = 1 - _MOMENTUM ** self._visits[place].reshape(-1, *[1] * (array.dim() - 1))
            move = self._how.alpha * momentum[place] / unbiased / (diagonal + self._damping[name])
            array[place] -= self.share * torch.maximum(torch.minimum(move, limits[name]), -limits[name])
            seen.grad = None

    def _limits(self, splats: Splats) -> dict[str, Tensor]:
        """Return the longest step of every parameter, positive."""
        limits = {name: torch.full_like(array, self._how.trust * _TRUST[name]) for name, array in splats.items()}
        size = torch.exp(splats.log_scales.mean(1))
        if isinstance(splats, StaticSplats):
            limits["means"] *= size[:, None]
            return limits
        life = torch.exp(-0.5 * splats.time_log_precisions).clamp(1 / max(1, self._frames - 1), 1.0)
        powers = life[:, None, None] ** torch.arange(float(splats.motion.shape[1]))[None, :, None]
        limits["motion"] *= size[:, None, None] / powers
        limits["rotation"] /= powers[:, :2]
        limits["time_centers"] *= life
        return limits


def _median(array: Tensor, axis: int) -> Tensor:
    return array.median(axis).values


@dataclasses.dataclass(frozen=True)
class _ProbedMovingSteps(MovingSteps):
    newton: NewtonSteps

    def _step(
        self, state: TrainState, context: RoundContext, fixed: FixedView, view: TrainingView, moving: MovingTiles
    ) -> None:
        rows = living_rows(state.dynamic, view.moment)
        if len(rows) and self.newton.due():
            living = rows_taken(state.dynamic, rows)
            living.map(lambda array: array.requires_grad_(True))
            picture = fixed.differentiable_frame(living, view.moment, tile_mask=moving.tiles).rgb
            self.newton.probe(picture, view, moving)
            self.newton.dynamic.learn(living, rows)
        super()._step(state, context, fixed, view, moving)
