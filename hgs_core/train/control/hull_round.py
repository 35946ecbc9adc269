"""Movers that stay in their hull, where cameras stand too far apart for pictures to agree on a place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import torch

from hgs_core.base.arrays import Doubles
from hgs_core.points.backdrop import Backdrop
from hgs_core.points.hull_surface import PROOF, soft_masks, views_of_movers
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.rotations import matrices
from hgs_core.scene.temporal import evaluate
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.round import RoundContext
from hgs_core.train.splat_sets import kept
from hgs_core.train.train_config import TrainConfig

__all__ = ["HullRound"]

_ROUNDS = 40  # rounds in a training, and those left out at first
_FROM = 0.1  # share of the iterations that pass before it: first, splats learn how they move
_LOOKED_AT = 24  # frames of the segment in a round
_ALIVE = 0.6  # least share of a splat's greatest opacity at which it is looked at
_OUTSIDE = 0.5  # share of the looked-at moments outside, from which on a splat goes
_REACH = 1.5  # standard deviations that lie in the hull
_BESIDE = 0.02  # share of the backdrop's radius, a hand's breadth of a room: as far a mover goes on unproved
_ROW = 1 << 32  # cells
_SHRINK = math.log(0.8)


@dataclass(frozen=True)
class HullRound:
    """Removes dynamic splats that lie outside the hull of motion, and shortens axes with both ends outside."""

    name: ClassVar[str] = "hull"
    on_host: ClassVar[bool] = True
    is_long: ClassVar[bool] = False
    config: TrainConfig
    backdrop: Backdrop

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        done, last = iteration + 1, self.config.iterations
        return done > _FROM * last and done % max(1, last // _ROUNDS) == 0

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        views, frames = context.views, context.segment.frames
        arrays = state.dynamic.map(lambda array: array.detach().numpy())
        away, looked = np.zeros(len(arrays)), np.zeros(len(arrays))
        sticks_out = np.zeros((len(arrays), 3), np.bool_)
        peak = opacities_of(arrays.opacity_logits)
        chosen = context.random(7).choice(frames, min(_LOOKED_AT, frames), replace=False)
        for frame in sorted(int(one) for one in chosen):
            xyz, quats, opacity = evaluate(arrays, frame / max(1, frames - 1))
            rows = np.flatnonzero(opacity > _ALIVE * peak)
            masks = soft_masks(views.moving(frame))
            seen = views_of_movers(views.cameras, masks, xyz[rows])
            near = self._near(xyz[rows], seen >= PROOF)
            looked[rows] += 1
            away[rows] += (seen == 0) | ((seen < PROOF) & ~near)
            ends = matrices(quats[rows]) * (_REACH * np.exp(arrays.log_scales[rows].astype(np.float64)))[:, None]
            for axis in range(3):
                tips = [xyz[rows] + sign * ends[:, :, axis] for sign in (1, -1)]
                out = [views_of_movers(views.cameras, masks, tip) == 0 for tip in tips]
                sticks_out[rows, axis] |= out[0] & out[1]
        state.dynamic.log_scales.add_(torch.from_numpy(_SHRINK * sticks_out).float())
        needed = away <= _OUTSIDE * looked
        state.replace(state.static, kept(state.dynamic, state.dynamic_optimiser, needed))
        state.history.pruned += int((~needed).sum())

    def _near(self, xyz: Doubles, proved: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return which places [P, 3] are above or below a proved one, or beside it."""
        out = xyz - np.array(self.backdrop.centre)
        side, ahead = self.backdrop.axes
        cells = np.floor(np.stack([out @ side, out @ ahead], 1) / (_BESIDE * self.backdrop.radius)).astype(np.int64)
        known = np.unique(cells[proved], axis=0)
        around = (known[:, None] + np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])).reshape(-1, 2)
        return np.isin(cells @ (1, _ROW), around @ (1, _ROW))
