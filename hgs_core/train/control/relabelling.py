"""Labels that follow the evidence: dynamic splats at rest become static, restless static ones dynamic.

A wrong label costs in both directions: a static splat cannot show what changes, and a dynamic one pays twice the bytes
for something that stands still. The first labels come from masks; these come from the scene itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.render.projection import rotation_matrices
from hgs_core.scene.camera import Camera
from hgs_core.scene.motion import COEFFICIENTS
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.scene.temporal import evaluate
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.hull import ever_inside
from hgs_core.train.control.round import RoundContext, is_one_of_ten
from hgs_core.train.control.static_residuals import temporal_residuals
from hgs_core.train.splat_sets import joined, kept, rows_of
from hgs_core.train.train_config import TrainConfig

__all__ = ["LabelRound", "as_dynamics", "as_statics", "standing_still"]


_CHECKED_MOMENTS = 9  # checked moments of the segment; odd: one is the middle
_STEADY_OPACITY = 0.9  # the least opacity in the segment over the greatest that still counts as constant
_CENTERS = (0.25, 0.75)  # lives that a splat which will not stand still is divided into
_HALF_LIFE = 0.3  # normalised time after which these have faded to half: they overlap
_MOST_AT_ONCE = 0.02  # share of the statics that one round may make dynamic, the most restless first (as Ex4DGS)


@dataclass(frozen=True)
class LabelRound:
    """Makes dynamic splats that stand still static, and statics under which the error varies with time dynamic.

    The config's `still_pixels` and `restless_error` are the two thresholds. Where it is known what moves, a static must
    lie in the hull of it at a moment: the error under a false point in the air varies, too, with what passes behind it.
    """

    name: ClassVar[str] = "labels"
    on_host: ClassVar[bool] = True
    is_long: ClassVar[bool] = True
    config: TrainConfig

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""
        return self.config.labels.adaptive and is_one_of_ten(self.config, iteration)

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        config, views, schedule = self.config, context.views, context.schedule
        restless = np.zeros(len(state.static), np.bool_)
        room = schedule.splat_budgets[1] - len(state.dynamic)
        if config.labels.restless_error > 0 and room > 1 and len(state.static):
            samples = views.samples(context.iteration)
            varies = temporal_residuals(state.static, state.dynamic, samples, config, state.shown)
            most = min(int(_MOST_AT_ONCE * len(state.static)), room // 2)
            worst = np.argsort(-varies, kind="stable")[:most]
            worst = worst[varies[worst] > config.labels.restless_error]
            if views.masked:
                places = state.static.means.numpy()[worst]
                worst = worst[ever_inside(places, views.cameras, schedule.frames, views.moving)]
            restless[worst] = True
        still = standing_still(state.dynamic, views.cameras, config.labels.still_pixels)
        to_static = as_statics(state.dynamic.take(rows_of(still)))
        to_dynamic = as_dynamics(state.static.take(rows_of(restless)), state.dynamic.motion.shape[1])
        state.replace(
            kept(state.static, state.static_optimiser, ~restless, to_static),
            kept(state.dynamic, state.dynamic_optimiser, ~still, to_dynamic),
        )
        state.history.relabelled(len(to_static), int(restless.sum()))


def standing_still(dynamic: DynamicSplats[Tensor], cameras: Sequence[Camera], pixels: float) -> npt.NDArray[np.bool_]:
    """Return [M] which dynamic splats do nothing that a static splat could not do.

    Those whose opacity is constant over the segment, and none of whose three axes' ends moves by more than `pixels` on
    any of the cameras' pictures during it.
    """
    arrays = dynamic.map(lambda array: array.detach().numpy())
    moments = _over_the_segment(arrays)
    opacities = np.stack([opacity for _, _, opacity in moments])
    steady = opacities.min(0) >= _STEADY_OPACITY * opacities.max(0)
    candidates = np.flatnonzero(steady & (opacities.max(0) > 0))
    if len(candidates) == 0:
        return np.zeros(len(steady), np.bool_)
    sizes = np.exp(np.asarray(arrays.log_scales, np.float64))[candidates]
    ends = np.stack([_axis_ends(m[candidates], q[candidates], sizes) for m, q, _ in moments])  # [9, K, 3, 3]
    travel = np.linalg.norm(ends - ends.mean(0), axis=-1).max((0, 2))  # [K] world units
    middle = moments[_CHECKED_MOMENTS // 2][0][candidates]
    still = np.ones(len(candidates), np.bool_)
    for camera in cameras:
        _, depth = camera.project(middle)
        seen = depth > camera.near
        still &= ~seen | (travel * max(camera.fx, camera.fy) <= pixels * np.where(seen, depth, 1.0))
    result = np.zeros(len(steady), np.bool_)
    result[candidates[still]] = True
    return result


def as_statics(dynamic: DynamicSplats[Tensor]) -> StaticSplats[Tensor]:
    """Fold the motion in: static splats as the given dynamic ones are in the middle of the segment."""
    arrays = dynamic.map(lambda array: array.detach().numpy())
    moments = _over_the_segment(arrays)
    means, quats, _ = moments[_CHECKED_MOMENTS // 2]
    opacity = np.clip(np.mean([opacity for _, _, opacity in moments], axis=0), 1e-6, 1 - 1e-6)
    return StaticSplats(
        _tensor(means),
        dynamic.log_scales.detach().clone(),
        _tensor(quats),
        _tensor(np.log(opacity / (1 - opacity))),
        dynamic.rgb.detach().clone(),
    )


def as_dynamics(static: StaticSplats[Tensor], coefficients: int = COEFFICIENTS[0]) -> DynamicSplats[Tensor]:
    """Return two resting dynamic splats per static one, one for each half of the segment, free to part.

    `coefficients` of motion are those of the set that they join, 4 or 6.
    """
    count = len(static)
    motion = torch.zeros(count, coefficients, 3)
    motion[:, 0] = static.means
    rotation = torch.stack([static.quats, torch.zeros_like(static.quats)], 1)
    precision = torch.full((count,), math.log(math.log(2) / _HALF_LIFE**2))
    lives = [
        DynamicSplats(
            motion,
            rotation,
            static.log_scales,
            static.opacity_logits,
            torch.full((count,), center),
            precision,
            static.rgb,
        )
        for center in _CENTERS
    ]
    return joined(*lives).map(Tensor.detach)


def _over_the_segment(dynamic: DynamicSplats[Floats]) -> list[tuple[Doubles, Doubles, Doubles]]:
    """Return positions, quaternions and opacities at moments from the segment's start to its end."""
    return [evaluate(dynamic, float(t)) for t in np.linspace(0, 1, _CHECKED_MOMENTS)]


def _axis_ends(
    means: npt.NDArray[np.float64], quats: npt.NDArray[np.float64], sizes: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return where the three axes of K splats end, one standard deviation out, [K, 3 axes, 3]."""
    axes = rotation_matrices(torch.from_numpy(quats)).numpy() * sizes[:, None, :]
    return np.asarray(means[:, None] + axes.transpose(0, 2, 1))


def _tensor(array: npt.NDArray[np.float64]) -> Tensor:
    return torch.tensor(array, dtype=torch.float32)
