"""Statics for the unseen parts of a backdrop, in the colours around them.

Behind a mover that never leaves, and above the pictures' upper edges, a training camera sees nothing, so nothing
learns. An eye beside the cameras looks into the void there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from torch import Tensor

from hgs_core.base.arrays import Doubles
from hgs_core.points.backdrop import Backdrop
from hgs_core.points.point_cloud import PointCloud
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.splats import StaticSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.round import RoundContext, is_after_share
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.splat_sets import kept
from hgs_core.train.train_config import TrainConfig

__all__ = ["FILLED_AT", "BackdropFill", "unseen_parts"]

FILLED_AT = 0.88
"""Share of the iterations before it is filled, after all pruning, which would remove the filling."""

_EYE = 0.3  # height of the eye that looks around, share of the radius
_SIDE = 32  # pixels of its six pictures
_COVERED = 0.95  # coverage of a pixel that counts as seen
_OPACITY = 0.98
_SIZE = 0.8  # standard deviation of what is added, distances between pixels
_EVERY_KNOWN = 3  # pixels; so many fewer colours to take means of
_NEARNESS = 3  # power of the inverse distance that weighs them


@dataclass(frozen=True)
class BackdropFill:
    """Adds statics, once, where an eye in the middle looks through the backdrop."""

    name: ClassVar[str] = "backdrop fill"
    on_host: ClassVar[bool] = True
    is_long: ClassVar[bool] = False
    config: TrainConfig
    backdrop: Backdrop

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        return is_after_share(self.config, iteration, (FILLED_AT,))

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        points = unseen_parts(self.backdrop, state.static, antialiased=self.config.antialiased)
        added, _ = initial_splats(points, context.segment.clock, context.segment.frames, opacity=_OPACITY)
        state.replace(kept(state.static, state.static_optimiser, None, added), state.dynamic)


def unseen_parts(backdrop: Backdrop, static: StaticSplats[Tensor], *, antialiased: bool) -> PointCloud:
    """Return points of the backdrop where statics do not cover it, with the colours of those around."""
    up = np.array(backdrop.up)
    eye = np.array(backdrop.centre) + _EYE * backdrop.radius * up
    places, colours, sizes, covered = [], [], [], []
    for camera in _around(eye, up, *backdrop.axes):
        drawn = rasterize(static, None, camera, gradients="none", backend="cpu", antialiased=antialiased)
        rows, columns = np.divmod(np.arange(_SIDE * _SIDE), _SIDE)
        rays = camera.rays(np.stack([columns + 0.5, rows + 0.5], 1))
        depths = backdrop.depths(eye, rays)
        alpha = drawn.alpha.numpy().reshape(-1)
        places.append(eye + rays * depths[:, None])
        sizes.append(_SIZE * depths / camera.fx)
        covered.append(alpha > _COVERED)
        colours.append((drawn.rgb.numpy().reshape(3, -1) / np.maximum(alpha, 1e-3)).T)
    xyz, rgb, size, seen = (np.concatenate(one) for one in (places, colours, sizes, covered))
    missing = np.flatnonzero(~seen)
    known = np.flatnonzero(seen)[::_EVERY_KNOWN]
    if len(known) == 0:
        return PointCloud.concatenate([])
    none = np.zeros(len(missing), np.float32)
    return PointCloud(
        xyz[missing].astype(np.float32),
        _means(xyz[missing], xyz[known], rgb[known]).astype(np.float32).clip(0, 1),
        none,
        none,
        size[missing].astype(np.float32),
        np.zeros((len(missing), 3), np.float32),
        backdrop.nearest(xyz[missing])[1].astype(np.float32),
    )


def _around(eye: Doubles, up: Doubles, side: Doubles, ahead: Doubles) -> list[Camera]:
    """Return six cameras that see every direction once."""
    half = _SIDE / 2
    return [
        Camera(f"side {number}", _SIDE, _SIDE, half, half, half, half, looking_at(eye, eye + way, up=above))
        for number, (way, above) in enumerate(
            [(side, up), (-side, up), (ahead, up), (-ahead, up), (up, side), (-up, side)]
        )
    ]


def _means(places: Doubles, known: Doubles, rgb: Doubles) -> Doubles:
    """Return the mean colours [P, 3] of known places, the nearer ones weighing more."""
    found = np.empty((len(places), 3))
    for first in range(0, len(places), 1024):
        part = slice(first, first + 1024)
        apart = np.sqrt(((places[part, None] - known) ** 2).sum(2))
        weights = np.maximum(apart, 1e-6) ** -float(_NEARNESS)
        found[part] = weights @ rgb / weights.sum(1, keepdims=True)
    return found
