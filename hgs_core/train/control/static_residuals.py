"""Residuals of static splats: the variation over time of the error under every splat."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.base.cores import core_pool
from hgs_core.render.contributions import contributions
from hgs_core.render.rasterize import rasterize
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView

__all__ = ["temporal_residuals"]

_MIN_PIXELS = 4.0  # least weight, in pixels, of a splat in a view that judges it


def temporal_residuals(
    static: StaticSplats[Tensor],
    dynamic: DynamicSplats[Tensor],
    cameras: Iterable[Iterable[TrainingView]],
    config: TrainConfig,
    shown: Callable[[Tensor, TrainingView], Tensor],
) -> npt.NDArray[np.float64]:
    """Return [N] by how much the mean colour error under each static splat varies over time, colour units.

    In each view the error under a splat is the mean of target minus picture, weighted by the splat's own weights
    T alpha, which are the derivative of the picture towards its colour. Its standard deviation over the moments of one
    camera is blind to errors that never change; a splat's figure is the median over the cameras that see it, 0 if none
    does.

    Args:
        static: the statics, N of them.
        dynamic: the dynamics that are drawn with them.
        cameras: for every camera that is asked, its views at several moments.
        config: of the run.
        shown: turns a picture into what the view's camera shows of it (colour correction).
    """
    with core_pool() as pool:
        deviations = list(pool.map(lambda views: _deviation(static, dynamic, views, config, shown), cameras))
    if not deviations:
        return np.zeros(len(static))
    stack = np.stack(deviations)  # [C, N], nan where a camera does not see the splat
    result = np.zeros(len(static))
    seen = ~np.isnan(stack).all(0)
    result[seen] = np.nanmedian(stack[:, seen], axis=0)
    return result


def _deviation(
    static: StaticSplats[Tensor],
    dynamic: DynamicSplats[Tensor],
    views: Iterable[TrainingView],
    config: TrainConfig,
    shown: Callable[[Tensor, TrainingView], Tensor],
) -> npt.NDArray[np.float64]:
    """Return the standard deviation over one camera's moments, [N]; nan where fewer than three of them show a splat."""
    sums, squares, counts = np.zeros((len(static), 3)), np.zeros((len(static), 3)), np.zeros(len(static))
    for view in views:
        rgb = static.rgb.detach().clone().requires_grad_(True)
        picture = rasterize(
            dataclasses.replace(static, rgb=rgb),
            dynamic,
            view.camera,
            view.moment,
            backend=config.backend,
            gradients="static",
            antialiased=config.antialiased,
        ).rgb
        error = view.target - shown(picture.detach(), view)
        picture.backward(error)  # type: ignore[no-untyped-call]
        weights = contributions(
            static, dynamic, view.camera, view.moment, backend=config.backend, antialiased=config.antialiased
        ).total[: len(static)]
        judged = weights >= _MIN_PIXELS
        assert rgb.grad is not None
        mean = np.where(judged[:, None], rgb.grad.numpy() / np.maximum(weights, _MIN_PIXELS)[:, None], 0.0)
        sums, squares, counts = sums + mean, squares + mean**2, counts + judged
    enough = counts >= 3
    count = np.maximum(counts, 1)[:, None]
    variance = np.maximum(squares / count - (sums / count) ** 2, 0).mean(1)
    return np.where(enough, np.sqrt(variance), np.nan)
