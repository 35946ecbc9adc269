"""The reference backend: plain torch, any device, float32 or float64, autograd; the truth for every test."""

from __future__ import annotations

from typing import TypeVar

import torch
from torch import Tensor

from hgs_core.render.compositing import composite
from hgs_core.render.projection import Ellipses, project
from hgs_core.render.temporal import Moment, alive, moment_of_dynamic, moment_of_static
from hgs_core.render.types import Render, ScreenStatistics, View
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["rasterize_reference"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])


def rasterize_reference(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View
) -> Render:
    """Render as `hgs_core.render.rasterize` describes."""
    camera, gradients, background = view.camera, view.gradients, view.background
    moments, rows = [], []  # rows: where each moment's splats stand in the statistics
    if static is not None and len(static):
        moments.append(moment_of_static(_tracked(static, gradients in ("all", "static"))))
        rows.append(torch.arange(len(static)))
    if dynamic is not None and len(dynamic):
        living = torch.nonzero(alive(dynamic, view.time))[:, 0]
        tracked = _tracked(dynamic, gradients in ("all", "dynamic"))
        moments.append(moment_of_dynamic(tracked.map(lambda array: array[living]), view.time))
        rows.append(living.cpu() + (len(static) if static is not None else 0))
    if not moments:
        nothing = torch.zeros(camera.height, camera.width)
        return Render(torch.tensor(background, dtype=nothing.dtype)[:, None, None] + nothing, nothing)
    moment = Moment(*(torch.cat([getattr(m, f) for m in moments]) for f in Moment.__dataclass_fields__))
    ellipses = project(moment, camera)
    if view.statistics is not None:
        _collect(view.statistics, ellipses, torch.cat(rows)[ellipses.index.cpu()], gradients, len(static or ()))
    mask = None if view.tile_mask is None else torch.as_tensor(view.tile_mask, device=moment.means.device)
    image = composite(ellipses, camera.width, camera.height, mask)
    backdrop = torch.tensor(background, dtype=image.dtype, device=image.device)[:, None, None]
    return Render(image[:3] + (1 - image[3]) * backdrop, image[3])


def _tracked(splats: S, wanted: bool) -> S:
    return splats if wanted else splats.map(Tensor.detach)


def _collect(statistics: ScreenStatistics, ellipses: Ellipses, rows: Tensor, gradients: str, statics: int) -> None:
    """Add to the statistics when the gradient of the screen positions passes by."""
    wanted = (rows < statics) if gradients == "static" else (rows >= statics) if gradients == "dynamic" else rows >= 0

    def add(gradient: Tensor) -> None:
        kept, norms = rows[wanted].numpy(), gradient.detach().cpu().norm(dim=1)[wanted].numpy()
        statistics.grad_norm_sum[kept] += norms
        statistics.count[kept] += 1

    if gradients != "none" and ellipses.means.requires_grad:
        ellipses.means.register_hook(add)  # type: ignore[no-untyped-call]
