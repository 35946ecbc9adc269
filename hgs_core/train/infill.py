"""New static splats where pictures of what stands still stay wrong.

Density control follows screen gradients. Under a large splat on a fine pattern those of its pixels cancel, and where
initialisation found nothing there may be no splat to multiply. So the error itself says where splats are missing: the
worst still pixels are swept for points, as births are for what moves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
import torch
from torch import Tensor

from hgs_core.points.point_cloud import PointCloud
from hgs_core.render.fixed_view import FixedView
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.births import chosen_births, find_births, picture_error
from hgs_core.train.config import TrainConfig
from hgs_core.train.training_views import TrainingView

__all__ = ["find_infill"]

_MOST_PIXELS = 4000  # of one picture that are swept


def find_infill(
    static: StaticSplats[Tensor],
    dynamic: DynamicSplats[Tensor],
    cameras: Iterable[Sequence[TrainingView]],
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
    seen_by, pictures, still, errors = [], [], [], []
    for views in cameras:
        camera = views[0].camera
        fixed = FixedView(static, camera, antialiased=config.antialiased, backend=config.backend)
        drawn = torch.stack([shown(fixed.frame(dynamic, view.moment).rgb, view) for view in views]).mean(0)
        truth = torch.stack([view.target for view in views]).mean(0)
        moving = [view.moving for view in views if view.moving is not None]
        picture = (truth.permute(1, 2, 0) * 255).round().to(torch.uint8).numpy()
        seen_by.append(camera)
        pictures.append(picture)
        errors.append(picture_error(drawn, picture))
        everywhere = torch.ones(camera.height, camera.width, dtype=torch.bool)
        still.append((~torch.stack(moving).any(0) if moving else everywhere).numpy())
    found = find_births(seen_by, pictures, still, errors, ranges, hull=False, pixels=_MOST_PIXELS)
    return chosen_births([found], most, generator)
