"""The schedule of a training: step sizes, resolution and budgets of splats."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.scene.splats import DynamicSplats
from hgs_core.train.train_config import TrainConfig

__all__ = ["Schedule", "share_alive"]

_AVERAGED_EVERY = 10  # iterations; within so few, splats hardly move

_CLOCKS_FROM = 0.1  # share of the iterations before cameras' clocks are learned
_LEAST_SHARE = 0.05  # least share of time that a splat counts as alive


@dataclass(frozen=True)
class Schedule:
    """The schedule of one run; every method is a pure function of the iteration (counted from 0)."""

    config: TrainConfig
    extent: float  # world units; positions move in multiples of it
    frames: int  # frames of the segment
    seconds: float = 0.0  # duration of the segment

    def resolution(self, iteration: int) -> float:
        """Return the factor by which pictures are resized: coarse first, then full."""
        return 0.5 if iteration < self.config.coarse_until * self.config.iterations else 1.0

    @property
    def splat_budgets(self) -> tuple[int, int]:
        """Return how many static and dynamic splats the segment may have in the end."""
        return self.config.splat_budgets(self.seconds)

    def budget(self, iteration: int, initial: int, final: int) -> int:
        """Return the splats allowed after the round that follows `iteration`: from `initial` to `final`, linearly."""
        progress = (iteration + 1) / max(1.0, self.config.density.end * self.config.iterations)
        return round(initial + (max(final, initial) - initial) * min(1.0, progress))

    def are_pulls_counted(self, iteration: int) -> bool:
        """Return whether density control will refine splats by the pulls of this iteration."""
        return iteration < self.config.density.end * self.config.iterations

    def static_rates(self, iteration: int) -> dict[str, float | Tensor]:
        """Return the step size of every field of the static set; held ones are multiplied by `held_statics`."""
        rates, held = self.config.learning_rates, iteration > self._hold_from
        multiple = self.config.held_statics if held else 1.0
        share = multiple * self.settling(iteration)
        return {
            "means": multiple * self.position_rate(iteration),
            "log_scales": share * rates.log_scale,
            "quats": share * rates.rotation,
            "opacity_logits": share * rates.opacity,
            "rgb": share * rates.rgb,
        }

    def dynamic_rates(self, iteration: int, dynamic: DynamicSplats[Tensor]) -> dict[str, float | Tensor]:
        """Return the step size of every field of the dynamic set, per splat; and per coefficient for the polynomials.

        All are in proportion to the root of the share of time for which a splat is alive (`share_alive`): RMSprop
        divides gradients by the root of their mean square over all steps, in most of which such a splat has none, so
        that each of its visits would move it the farther the fewer there are (docs/training.md, "Steps of what is
        rarely seen").

        A coefficient of the k-th power of time moves a splat in proportion to the k-th power of its life, so its step
        is divided by that: at the ends of a life, a step of any coefficient moves the splat equally far. Otherwise what
        lives shortly could never learn to move fast.
        """
        rates, position, share = self.config.learning_rates, self.position_rate(iteration), self.settling(iteration)
        visits = torch.ones_like(dynamic.time_centers)  # [M] factor of every step size
        if self.config.steps_by_life:
            visits = share_alive(dynamic).sqrt()
        rows, polynomials = visits[:, None], visits[:, None, None]
        life = torch.exp(-0.5 * dynamic.time_log_precisions).clamp(1 / max(1, self.frames - 1), 1.0)  # [M]
        order, coefficients = self.config.motion_order, dynamic.motion.shape[1]
        inverse = torch.ones(len(life), coefficients, device=life.device)  # powers of 1 / life, from the 0th
        inverse[:, 1:] = (1 / life)[:, None]
        inverse = inverse.cumprod(1)
        factors = torch.tensor([1.0] + [rates.motion] * order + [0.0] * (coefficients - 1 - order), device=life.device)
        turning = torch.tensor([rates.rotation, rates.turning], device=life.device)
        return {
            "motion": polynomials * (position * factors * inverse)[:, :, None],
            "rotation": polynomials * (share * turning * inverse[:, :2])[:, :, None],
            "log_scales": rows * (share * rates.log_scale),
            "opacity_logits": visits * (share * rates.opacity),
            "time_centers": visits * (share * rates.time_center),
            "time_log_precisions": visits * (share * rates.time_log_precision),
            "rgb": rows * (share * rates.rgb),
        }

    def settling(self, iteration: int) -> float:
        """Return the share that is left of all step sizes but the positions': 1 until `settle_from`, then a cosine.

        A step looks at one view at one moment, so that parameters whose steps stay as large never come to rest; from
        `hold_from` on the share stays as it is, and their mean comes to rest instead.
        """
        first, end, at = self.config.settle_from * self.config.iterations, self.config.iterations, self._held(iteration)
        if at <= first:
            return 1.0
        fall = 0.5 * (1 - math.cos(math.pi * (at - first) / (end - first)))
        return 1.0 + (self.config.settled - 1.0) * fall

    def position_rate(self, iteration: int) -> float:
        """Return the step size of positions, world units, which stays as it is from `hold_from` on."""
        rates, progress = self.config.learning_rates, self._held(iteration) / self.config.iterations
        if rates.position <= 0:
            return 0.0
        return self.extent * float(rates.position ** (1 - progress) * max(rates.position_final, 1e-12) ** progress)

    def time_shift_rate(self, iteration: int) -> float:
        """Return the step size of the cameras' clocks in seconds, once the scene has taken shape; it falls to 0."""
        share, config = iteration / self.config.iterations, self.config
        frame = self.seconds / max(1, self.frames - 1)
        return 0.0 if share < _CLOCKS_FROM else config.learning_rates.time_shift * frame * (1 - share)

    def is_averaged(self, done: int) -> bool:
        """Return whether the mean takes in the splats after so many iterations; those at the end are taken in."""
        config = self.config
        return done > config.average_from * config.iterations and (config.iterations - done) % _AVERAGED_EVERY == 0

    def _held(self, iteration: int) -> float:
        """Return the iteration that gives the step sizes."""
        return min(iteration, self._hold_from)

    @property
    def _hold_from(self) -> float:
        return self.config.hold_from * self.config.iterations


def share_alive(dynamic: DynamicSplats[Tensor]) -> Tensor:
    """Return for which share of the segment's time splats are alive, [M], from 0.05 to 1.

    A splat that fades as exp(-s (t - mu)^2) counts as alive from 1.5 / sqrt(s) before mu to as long after it: while a
    tenth of its opacity is left.
    """
    return (3.0 * torch.exp(-0.5 * dynamic.time_log_precisions)).clamp(_LEAST_SHARE, 1.0)
