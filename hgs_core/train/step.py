"""One step of training: a view is drawn, compared with its target, and differentiated towards one set or both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.render.rasterize import rasterize
from hgs_core.render.tiles import tiles_to_pixels
from hgs_core.render.types import Gradients, ScreenStatistics
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.colour_correction import CameraColours, ColourCorrection
from hgs_core.train.loss import photometric_loss
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView

__all__ = ["Step", "take_step"]


@dataclass(frozen=True)
class Step:
    """The results of a step; the gradients of the splats lie in their `.grad`."""

    picture: Tensor  # [3, H, W] as the scene shows it: without colour correction
    loss: float
    colour_gradient: CameraColours | None  # towards the camera's colours


def take_step(
    static: StaticSplats[Tensor],
    dynamic: DynamicSplats[Tensor],
    view: TrainingView,
    config: TrainConfig,
    *,
    gradients: Gradients,
    tiles: npt.NDArray[np.bool_] | None = None,
    ignored: Tensor | None = None,
    correction: ColourCorrection | None = None,
    statistics: ScreenStatistics | None = None,
) -> Step:
    """Differentiate the loss of one view towards the sets that `gradients` names.

    Args:
        static: the statics that are drawn.
        dynamic: the dynamics that are drawn.
        view: the view and its target.
        config: of the run.
        gradients: which sets learn.
        tiles: [ceil(H/16), ceil(W/16)] tiles that are drawn; None: all.
        ignored: [H, W] pixels that count as perfect, as those outside `tiles` do; None: none.
        correction: the cameras' colours, which the picture is given before it is compared.
        statistics: what density control counts, added to.
    """
    learning = [s for name, s in (("static", static), ("dynamic", dynamic)) if gradients in (name, "all")]
    for splats in learning:
        splats.map(lambda array: array.requires_grad_(True))
    picture = rasterize(
        static,
        dynamic,
        view.camera,
        view.moment,
        backend=config.backend,
        gradients=gradients,
        tile_mask=tiles,
        statistics=statistics,
        antialiased=config.antialiased,
    ).rgb
    compared, colours = picture, None
    if correction is not None:
        colours = correction.learning(view.place)
        compared = colours.shown(picture, view.camera)
    if tiles is not None:
        drawn = torch.from_numpy(tiles_to_pixels(tiles, view.camera.width, view.camera.height)).to(picture.device)
        compared = torch.where(drawn, compared, view.target)
    if ignored is not None:
        compared = torch.where(ignored, view.target, compared)
    loss = photometric_loss(compared, view.target, config.dssim)
    loss.backward()  # type: ignore[no-untyped-call]
    for splats in learning:
        splats.map(lambda array: array.requires_grad_(False))
    return Step(picture.detach(), float(loss.detach()), None if colours is None else colours.gradient())
