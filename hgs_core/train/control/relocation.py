"""Density control by relocation: invisible splats move onto visible ones, and positions jitter while they search.

After "3D Gaussian Splatting as Markov Chain Monte Carlo" (Kheradmand et al., 2024). A splat that is too transparent to
be seen is not removed but becomes a copy of a living one, drawn with a probability in proportion to its opacity; the
same draw adds splats up to the budget. Opacity and size of all copies are lowered so that together they look as one did
(section 4.3, equation 9), and transparent splats are pushed about by noise (equation 8).
"""

from __future__ import annotations

import dataclasses
import math
from typing import ClassVar, TypeVar

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.render.projection import rotation_matrices
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.density import peak_opacity
from hgs_core.train.control.round import BudgetRound, RoundContext
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.splat_sets import joined

__all__ = ["NoiseRound", "RelocationRound", "disturb", "relocate", "shared_among"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])

_NOISE_FACTOR = 5e5  # factor of equation 8, in the authors' code, on the step size of positions
_STEEPNESS = 100.0  # slope of the sigmoid of 1 - opacity that fades the noise
_TRANSPARENCY_HALFWAY = 0.995  # its half: opacity 0.005
_STILL_OPACITY = 0.1  # opacity above which noise is less than a ten-thousandth and left out
_MOST_TERMS = 150  # terms of equation 9: later ones are less than 14^j / j!, for any number of copies
_MOST_OPAQUE = 1 - 1e-6  # so that logits stay finite


@dataclasses.dataclass(frozen=True)
class RelocationRound(BudgetRound):
    """Moves the dead of both sets onto the living and fills each one's budget; copies inherit all but opacity and size.

    The budget is that of the round, as for cloning and splitting. The paper's 5 % a round would leave the statics of a
    short schedule far below theirs, and fill that of the dynamics before births can use it.
    """

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        schedule, most, first = context.schedule, context.schedule.splat_budgets, context.first_counts
        generator, dead = context.random(3), self.config.density.prune_opacity
        static, dynamic = state.static, state.dynamic
        if context.statics_learn and len(static):
            budget = schedule.budget(context.iteration, first[0], most[0])
            static = relocate(static, state.static_optimiser, budget, dead, generator)
        if len(dynamic):
            budget = schedule.budget(context.iteration, first[1], most[1])
            dynamic = relocate(dynamic, state.dynamic_optimiser, budget, dead, generator)
        state.replace(static, dynamic)


class NoiseRound:
    """Adds the noise that goes with relocation to the positions of both sets, after every iteration."""

    name: ClassVar[str] = "noise"
    on_host: ClassVar[bool] = False
    is_long: ClassVar[bool] = False

    def due(self, iteration: int) -> bool:
        """Return that the round follows every iteration."""
        return True

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        schedule = context.schedule
        generator = context.random(8)
        step = schedule.position_rate(context.iteration)
        if context.statics_learn:
            disturb(state.static, step, schedule.extent, generator)
        disturb(state.dynamic, step, schedule.extent, generator)


def relocate(splats: S, optimiser: RmsProp[S], budget: int, dead: float, generator: np.random.Generator) -> S:
    """Move the dead onto the living and add copies of these up to the budget; `optimiser` follows.

    Args:
        splats: the set, float32 on the CPU.
        optimiser: its optimiser; copies and what they are copies of start with zero moments.
        budget: splats wanted afterwards; with more there already, none are added.
        dead: opacity below which a splat is dead: its greatest one at a moment of the segment. So is one that is not
            finite.
        generator: of the draw.

    Returns:
        The new set: splats that nothing was copied from, in order, then all copies; nothing changes where none lives.
    """
    with torch.no_grad():
        opacity = peak_opacity(splats).double().numpy()
        alive = np.flatnonzero((opacity >= dead) & (opacity > 0))
        copies = max(len(splats), budget) - len(alive)
        if len(alive) == 0 or copies == 0:
            return splats
        drawn = generator.choice(alive, copies, p=opacity[alive] / opacity[alive].sum())
        shares = 1 + np.bincount(drawn, minlength=len(splats))  # copies that a splat becomes
        chosen = np.flatnonzero(shares > 1)
        untouched = torch.from_numpy(alive[shares[alive] == 1])
        parts = _divided(splats.take(torch.from_numpy(chosen)), shares[chosen])
        optimiser.select(untouched, len(parts))
        return joined(splats.take(untouched), parts)


def shared_among(
    opacity: npt.NDArray[np.float64], copies: npt.NDArray[np.int64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the opacity of each of `copies` [K] splats that look like one of `opacity` [K], and their relative size.

    Equation 9: o' = 1 - (1 - o)^(1/n), so that the centres agree, and sizes by o over the integral of the n copies'
    profile along a line, sum over i = 1..n and k = 0..i-1 of binom(i-1, k) (-1)^k o'^(k+1) / sqrt(k+1). Summed over i
    first, that is the sum over j = 1..n of binom(n, j) (-1)^(j+1) o'^j / sqrt(j).
    """
    shared = -np.expm1(np.log1p(-opacity) / copies)
    size = np.ones_like(opacity)
    for n in np.unique(copies):
        rows = copies == n
        term, total = -np.ones(int(rows.sum())), np.zeros(int(rows.sum()))
        for j in range(1, min(int(n), _MOST_TERMS) + 1):
            term = -term * shared[rows] * (n - j + 1) / j  # binom(n, j) (-1)^(j+1) o'^j
            total += term / math.sqrt(j)
        size[rows] = opacity[rows] / total
    return shared, size


def disturb(splats: S, step: float, extent: float, generator: np.random.Generator) -> None:
    """Push transparent splats about in place, by noise of the shape of their own Gaussian (equation 8).

    Args:
        splats: the set, float32.
        step: the step size of positions, world units.
        extent: of the scene, world units. Equation 8 multiplies a variance by a step, so its noise depends on the
            unit of length; here the unit is the extent.
        generator: of the noise.
    """
    with torch.no_grad():
        rows = torch.nonzero(torch.sigmoid(splats.opacity_logits) < _STILL_OPACITY)[:, 0]
        faint = splats.take(rows)
        fade = torch.sigmoid(_STEEPNESS * (1 - torch.sigmoid(faint.opacity_logits) - _TRANSPARENCY_HALFWAY))
        quats = faint.rotation[:, 0] if isinstance(faint, DynamicSplats) else faint.quats
        axes = rotation_matrices(quats) * torch.exp(faint.log_scales)[:, None, :]
        normal = torch.from_numpy(generator.standard_normal((len(rows), 3, 1), np.float32)).to(axes.device)
        shift = (axes @ (axes.transpose(1, 2) @ normal))[..., 0] * (_NOISE_FACTOR * step / extent**2 * fade)[:, None]
        positions = splats.motion[:, 0] if isinstance(splats, DynamicSplats) else splats.means
        positions[rows] += shift


def _divided(parents: S, copies: npt.NDArray[np.int64]) -> S:
    """Return so many copies [K] of each parent, which look as it did; of a dynamic one, at the peak of its life."""
    opacity = torch.sigmoid(parents.opacity_logits.double()).clamp_max(_MOST_OPAQUE).numpy()
    shared, size = shared_among(opacity, copies)
    smaller = dataclasses.replace(
        parents,
        opacity_logits=torch.from_numpy(np.log(shared) - np.log1p(-shared)).float(),
        log_scales=parents.log_scales + torch.from_numpy(np.log(size)).float()[:, None],
    )
    return smaller.take(torch.from_numpy(np.repeat(np.arange(len(copies)), copies)))
