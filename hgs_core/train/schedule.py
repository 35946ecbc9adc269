"""What changes over a training run: step sizes, resolution and the rounds of density control."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from hgs_core.train.config import TrainConfig

__all__ = ["Schedule"]

_REFERENCE_SPAN = 50  # frames; the segment length that the step sizes of motion were published for


@dataclass(frozen=True)
class Schedule:
    """The schedule of one run; every method is a pure function of the cycle (counted from 0)."""

    config: TrainConfig
    extent: float  # world units; positions move in multiples of it
    frames: int  # of the segment

    def resolution(self, cycle: int) -> float:
        """Return the factor by which pictures are resized: coarse first, then full."""
        return 0.5 if cycle < self.config.coarse_until * self.config.cycles else 1.0

    def densifies_after(self, cycle: int) -> bool:
        """Return whether a round of density control follows this cycle."""
        done = cycle + 1
        first, last = (share * self.config.cycles for share in (self.config.densify_from, self.config.densify_until))
        return done % self.config.densify_every == 0 and first <= done <= last

    def budget(self, cycle: int, initial: int, final: int) -> int:
        """Return the splats allowed after the round that follows `cycle`: from `initial` to `final`, linearly."""
        progress = (cycle + 1) / max(1.0, self.config.densify_until * self.config.cycles)
        return round(initial + (max(final, initial) - initial) * min(1.0, progress))

    def static_rates(self, cycle: int) -> dict[str, float | Tensor]:
        """Return the step size of every field of the static set."""
        rates = self.config.learning_rates
        return {
            "means": self._position_rate(cycle),
            "log_scales": rates.log_scale,
            "quats": rates.rotation,
            "opacity_logits": rates.opacity,
            "rgb": rates.rgb,
        }

    def dynamic_rates(self, cycle: int) -> dict[str, float | Tensor]:
        """Return the step size of every field of the dynamic set; per coefficient for the polynomials."""
        rates = self.config.learning_rates
        position = self._position_rate(cycle)
        higher = position * rates.motion * max(1.0, self.frames / _REFERENCE_SPAN)
        return {
            "motion": torch.tensor([position, higher, higher, higher])[:, None],
            "rotation": torch.tensor([rates.rotation, rates.turning])[:, None],
            "log_scales": rates.log_scale,
            "opacity_logits": rates.opacity,
            "time_centers": rates.time_center,
            "time_log_precisions": rates.time_log_precision,
            "rgb": rates.rgb,
        }

    def _position_rate(self, cycle: int) -> float:
        rates, progress = self.config.learning_rates, cycle / self.config.cycles
        if rates.position <= 0:
            return 0.0
        return self.extent * float(rates.position ** (1 - progress) * max(rates.position_final, 1e-12) ** progress)
