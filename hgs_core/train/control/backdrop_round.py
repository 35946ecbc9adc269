"""Statics that lie at given depths or on a backdrop: thin discs, unless two cameras show where they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.points.backdrop import Backdrop
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera
from hgs_core.scene.rotations import matrices, product, unit_quaternions
from hgs_core.scene.splats import StaticSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.backdrop_fill import FILLED_AT
from hgs_core.train.control.round import RoundContext
from hgs_core.train.train_config import TrainConfig

__all__ = ["BackdropRound", "laid_on", "shown_once"]

_EVERY = 10  # iterations
_LONGEST = 0.02  # longest axis on the floor, share of the radius: wide discs cover the feet behind their middles
_LEVEL = 0.9  # cosine of the slope up to which a given surface is like a floor
_THICKNESS = 0.1  # shortest axis, most share of the middle one


@dataclass(frozen=True)
class BackdropRound:
    """Lays the statics in their surface again, but for those in two pictures: these agree on their places."""

    name: ClassVar[str] = "backdrop"
    on_host: ClassVar[bool] = True
    is_long: ClassVar[bool] = False
    config: TrainConfig
    backdrop: Backdrop

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        return (iteration + 1) % _EVERY == 0

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place; the optimiser's moments stay."""
        filled = context.iteration + 1 >= FILLED_AT * self.config.iterations
        rows = torch.from_numpy(shown_once(state.static, context.views.cameras))
        laid = laid_on(self.backdrop, state.static.take(rows), context.views.cameras, wide=filled)
        state.static.means[rows] = laid.means
        state.static.quats[rows] = laid.quats
        state.static.log_scales[rows] = laid.log_scales


def shown_once(static: StaticSplats[Tensor], cameras: Sequence[Camera]) -> npt.NDArray[np.int64]:
    """Return the rows [R] of statics with centres in fewer than two cameras' pictures, whether or not hidden there."""
    xyz = static.means.numpy().astype(np.float64)
    pictures = np.zeros(len(xyz), np.int64)
    for camera in cameras:
        pictures[pixels_inside(camera, xyz)[0]] += 1
    return np.flatnonzero(pictures < 2)


def laid_on(
    backdrop: Backdrop, static: StaticSplats[Tensor], cameras: Sequence[Camera] = (), *, wide: bool = False
) -> StaticSplats[Tensor]:
    """Return statics at their cameras' given depths, else the nearest places of the backdrop, thin and flat in it.

    On the floor they are narrow, too, unless `wide`.
    """
    xyz, up = static.means.numpy().astype(np.float64), np.array(backdrop.up)
    places, normals = backdrop.nearest(xyz)
    on_floor = (places - np.array(backdrop.centre)) @ up < 1e-6 * backdrop.radius
    if backdrop.given is not None:
        held = backdrop.given.held(cameras, xyz)
        places[held.rows], normals[held.rows] = held.xyz, held.normals
        on_floor[held.rows] = np.abs(held.normals @ up) > _LEVEL
    sizes = static.log_scales.numpy().astype(np.float64)
    if not wide:
        sizes[on_floor] = np.minimum(sizes[on_floor], math.log(_LONGEST * backdrop.radius))
    quats = unit_quaternions(static.quats.numpy())
    rows, thin = np.arange(len(sizes)), sizes.argmin(1)
    axis = matrices(quats)[rows, :, thin]
    axis = np.where((axis * normals).sum(1, keepdims=True) < 0, -axis, axis)
    turn = np.concatenate([1 + (axis * normals).sum(1, keepdims=True), np.cross(axis, normals)], 1)
    quats = product(unit_quaternions(turn), quats)
    limit = np.sort(sizes, axis=1)[:, 1] + math.log(_THICKNESS)
    sizes[rows, thin] = np.minimum(sizes[rows, thin], limit)
    return StaticSplats(
        torch.from_numpy(places.astype(np.float32)),
        torch.from_numpy(sizes.astype(np.float32)),
        torch.from_numpy(quats.astype(np.float32)),
        static.opacity_logits,
        static.rgb,
    )
