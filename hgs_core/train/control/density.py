"""Adaptive density control: clone, split and prune, with labels inherited and budgets kept.

After 3D Gaussian Splatting (Kerbl et al., 2023, section 5.2), without opacity resets: the budget grows linearly over
the densification rounds, and within it the splats with the largest screen gradients are refined first. A clone's and
its parent's opacities are lowered so that the pair covers as much as the parent did (Rota Bulo et al., 2024).
"""

from __future__ import annotations

import dataclasses
import math
from typing import ClassVar, TypeVar

import torch
from torch import Tensor

from hgs_core.render.projection import rotation_matrices
from hgs_core.render.types import ScreenStatistics
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.round import RoundContext
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.splat_sets import joined
from hgs_core.train.train_config import TrainConfig

__all__ = ["DensityPlan", "DensityRound", "is_fog", "peak_opacity", "refine"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])

_FOG_SIZE = 0.3  # share of the extent (3DGS removes any splat above 0.1; moving parts can be as large)
_SPLIT_SHRINK = 1.6  # 3DGS: the halves of a split splat are this much smaller


@dataclasses.dataclass(frozen=True)
class DensityRound:
    """Prunes, clones and splits both sets, each within its own budget; children inherit their parent's label."""

    name: ClassVar[str] = "density"
    on_host: ClassVar[bool] = True
    is_long: ClassVar[bool] = False
    config: TrainConfig

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        config, done = self.config, iteration + 1
        first, last = (share * config.iterations for share in (config.density.start, config.density.end))
        return done % config.density.every == 0 and first <= done <= last

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        schedule, statics, seen = context.schedule, len(state.static), state.statistics
        seed = int(context.random(3).integers(2**62))
        generator = torch.Generator().manual_seed(seed)

        def plan(first: int, most: int) -> DensityPlan:
            budget = schedule.budget(context.iteration, first, most)
            half_width = 0.5 * max(context.camera.width, context.camera.height)
            return DensityPlan(budget, schedule.extent, half_width, self.config, generator)

        first, most = context.first_counts, schedule.splat_budgets
        static, dynamic = state.static, state.dynamic
        if context.statics_learn and statics:
            static = refine(static, state.static_optimiser, seen.rows(slice(0, statics)), plan(first[0], most[0]))
        if len(dynamic):
            dynamic = refine(dynamic, state.dynamic_optimiser, seen.rows(slice(statics, None)), plan(first[1], most[1]))
        state.replace(static, dynamic)


@dataclasses.dataclass(frozen=True)
class DensityPlan:
    """The limits of one round on one set of splats."""

    budget: int  # splats allowed afterwards
    extent: float  # world units
    half_width: float  # pixels; half the image's longer side, turns gradients per pixel into gradients per half image
    config: TrainConfig
    generator: torch.Generator

    @property
    def split_scale(self) -> float:
        """Return the standard deviation, world units, above which splats are split, and below which cloned."""
        return self.config.density.clone_scale * self.extent


def refine(splats: S, optimiser: RmsProp[S], statistics: ScreenStatistics, plan: DensityPlan) -> S:
    """Prune invisible splats, then clone or split those with the largest gradients; `optimiser` follows.

    Args:
        splats: the set, float32 on the CPU.
        optimiser: its optimiser; new splats start with zero moments.
        statistics: of this set's rows alone, since the last round.
        plan: budgets and thresholds.

    Returns:
        The new set: survivors that were not split, in order, then clones, then the halves of split splats.
    """
    with torch.no_grad():
        keep = (peak_opacity(splats) >= plan.config.density.prune_opacity) & ~is_fog(splats, plan.extent, plan.config)
        pull = torch.from_numpy(statistics.pull_sum / statistics.count.clip(1)) * plan.half_width
        pull = torch.where(keep, pull, torch.zeros_like(pull))
        room = max(0, plan.budget - int(keep.sum()))
        wanted = pull > plan.config.density.grow_gradient
        if int(wanted.sum()) > room:
            chosen = torch.zeros_like(wanted)
            chosen[torch.sort(pull, descending=True, stable=True).indices[:room]] = True
            wanted &= chosen
        large = splats.log_scales.amax(1) > math.log(plan.split_scale)
        split, clone = wanted & large, wanted & ~large
        survivors = torch.nonzero(keep & ~split)[:, 0]
        faded = dataclasses.replace(
            splats, opacity_logits=torch.where(clone, _halved(splats.opacity_logits), splats.opacity_logits)
        )
        halves = _halves(splats.take(torch.nonzero(split)[:, 0]), plan.generator)
        added = joined(faded.take(torch.nonzero(clone)[:, 0]), halves)
        result = joined(faded.take(survivors), added)
        optimiser.select(survivors, len(added))
        return result


def peak_opacity(splats: StaticSplats[Tensor] | DynamicSplats[Tensor]) -> Tensor:
    """Return the greatest opacity [N] that splats have at a moment of the segment; -1 for those that are not finite."""
    peak = torch.sigmoid(splats.opacity_logits)
    if isinstance(splats, DynamicSplats):
        away = (splats.time_centers - splats.time_centers.clamp(0, 1)).square()
        peak = peak * torch.exp(-torch.exp(splats.time_log_precisions) * away)
    finite = torch.ones_like(peak, dtype=torch.bool)
    for _, array in splats.items():
        finite &= torch.isfinite(array).flatten(1).all(1) if array.dim() > 1 else torch.isfinite(array)
    return torch.where(finite, peak, -torch.ones_like(peak))


def is_fog(splats: StaticSplats[Tensor] | DynamicSplats[Tensor], extent: float, config: TrainConfig) -> Tensor:
    """Return which splats [N] are dynamic and too large to be a thing that moves: one of them can veil every view.

    Where all splats are dynamic, walls are too, and none is.
    """
    if isinstance(splats, StaticSplats) or config.labels.initial == "dynamic":
        return torch.zeros(len(splats), dtype=torch.bool)
    return splats.log_scales.amax(1) > math.log(_FOG_SIZE * extent)


def _halved(logits: Tensor) -> Tensor:
    """The opacity that, composited twice, covers as much as before: 1 - sqrt(1 - o)."""
    halved = 1 - torch.sqrt(1 - torch.sigmoid(logits).clamp_max(0.999))
    return torch.logit(halved)


def _halves(parents: S, generator: torch.Generator) -> S:
    """Two smaller splats per parent, drawn from its Gaussian."""
    quats = parents.rotation[:, 0] if isinstance(parents, DynamicSplats) else parents.quats
    axes = rotation_matrices(quats) * torch.exp(parents.log_scales)[:, None, :]
    pieces = []
    for _ in range(2):
        offset = (axes @ torch.randn((len(parents), 3, 1), generator=generator))[..., 0]
        smaller = parents.log_scales - math.log(_SPLIT_SHRINK)
        if isinstance(parents, DynamicSplats):
            motion = parents.motion.clone()
            motion[:, 0] += offset
            pieces.append(dataclasses.replace(parents, motion=motion, log_scales=smaller))
        else:
            pieces.append(dataclasses.replace(parents, means=parents.means + offset, log_scales=smaller))
    return joined(*pieces)
