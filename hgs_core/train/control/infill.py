"""New static splats where still pixels stay wrong.

Density control follows screen gradients. Under a large splat on a fine pattern those of its pixels cancel, and where
initialisation found nothing there may be no splat to multiply. So the error itself says where splats are missing: the
worst still pixels are swept for points, as births are for what moves.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.base.cores import core_pool
from hgs_core.points.point_cloud import PointCloud
from hgs_core.points.sweep import depth_ranges
from hgs_core.render.fixed_view import FixedView
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.missing_points import chosen_points, find_missing_points, picture_error
from hgs_core.train.control.round import RoundContext, is_one_of_ten
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.splat_sets import kept
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView

__all__ = ["InfillRound", "find_infill"]

_MOST_PIXELS = 4000  # swept pixels of one picture
_OPACITY = 0.5


@dataclass(frozen=True)
class InfillRound:
    """Adds static splats where still pixels are wrong, at most the share `infill` of the budget."""

    name: ClassVar[str] = "infill"
    on_host: ClassVar[bool] = True
    is_long: ClassVar[bool] = True
    config: TrainConfig

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0: the ten in which labels change, too."""
        config = self.config
        return config.density.infill > 0 and config.labels.initial != "dynamic" and is_one_of_ten(config, iteration)

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""
        config, budget = self.config, context.schedule.splat_budgets[0]
        generator = context.random(6)
        most = min(round(config.density.infill * budget), budget - len(state.static))
        if most <= 0:
            return
        ranges = depth_ranges(context.views.cameras, state.static.means.numpy())
        views = context.views.everywhere(context.iteration, context.size)
        points = find_infill(state.static, state.dynamic, views, config, state.shown, ranges, most, generator)
        added, _ = initial_splats(points, context.segment.clock, context.segment.frames, opacity=_OPACITY)
        state.replace(kept(state.static, state.static_optimiser, None, added), state.dynamic)
        state.history.infilled += len(added)


def find_infill(
    static: StaticSplats[Tensor],
    dynamic: DynamicSplats[Tensor],
    cameras: Iterable[Iterable[TrainingView]],
    config: TrainConfig,
    shown: Callable[[Tensor, TrainingView], Tensor],
    ranges: Sequence[tuple[float, float]],
    most: int,
    generator: np.random.Generator,
) -> PointCloud:
    """Return at most `most` points that explain still pixels that are wrong at several moments.

    Args:
        static: the statics that are drawn.
        dynamic: the dynamics that are drawn with them.
        cameras: for every training camera, its views at several moments, with what moves in them if that is known.
        config: of the run.
        shown: turns a picture into what the view's camera shows of it (colour correction).
        ranges: nearest and farthest depth of each camera.
        most: points.
        generator: of the draw.
    """

    def look(views: Iterable[TrainingView]) -> _StillPicture:
        return _still_picture(static, dynamic, views, config, shown)

    with core_pool() as pool:
        found = list(pool.map(look, cameras))
    missing = find_missing_points(
        [one.camera for one in found],
        [one.picture for one in found],
        [one.still for one in found],
        [one.error for one in found],
        ranges,
        hull=False,
        pixels=_MOST_PIXELS,
    )
    return chosen_points([missing], most, generator)


@dataclass(frozen=True)
class _StillPicture:
    """The still pixels of a camera's pictures of several moments."""

    camera: Camera
    picture: npt.NDArray[np.uint8]  # [H, W, 3] mean over the moments
    still: npt.NDArray[np.bool_]  # [H, W] pixels that never move
    error: npt.NDArray[np.float32]  # [H, W] error of the mean drawn picture, levels of 255


def _still_picture(
    static: StaticSplats[Tensor],
    dynamic: DynamicSplats[Tensor],
    views: Iterable[TrainingView],
    config: TrainConfig,
    shown: Callable[[Tensor, TrainingView], Tensor],
) -> _StillPicture:
    """Draw one camera's views, and take the means of these pictures and of the true ones.

    They are summed one by one: at a megapixel the pictures of a few moments are a tenth of a training's memory.
    """
    remaining = iter(views)
    first = next(remaining)
    camera, count = first.camera, 0
    fixed = FixedView(static, camera, antialiased=config.antialiased, backend=config.backend)
    truths, drawn = (torch.zeros(3, camera.height, camera.width) for _ in range(2))
    still = torch.ones(camera.height, camera.width, dtype=torch.bool)
    for view in itertools.chain([first], remaining):
        truths += view.target
        drawn += shown(fixed.frame(dynamic, view.moment).rgb, view)
        if view.moving is not None:
            still &= ~view.moving
        count += 1
    picture = ((truths / count).permute(1, 2, 0) * 255).round().to(torch.uint8).numpy()
    return _StillPicture(camera, picture, still.numpy(), picture_error(drawn / count, picture))
