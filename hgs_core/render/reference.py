"""The reference backend: plain torch, any device, float32 or float64, autograd; the truth for every test.

Splats are projected in float64 whatever their type; pixels are computed in the type of the splats, at least float32.
"""

from __future__ import annotations

import dataclasses
from typing import TypeVar

import torch
from torch import Tensor

from hgs_core.render.compositing import blend, composite
from hgs_core.render.constants import TILE
from hgs_core.render.finite import refuse_non_finite
from hgs_core.render.moment import Moment, alive, moment_of_dynamic, moment_of_static
from hgs_core.render.projection import Ellipses, project
from hgs_core.render.types import Contributions, Render, ScreenStatistics, View
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["contributions_reference", "rasterize_reference"]

S = TypeVar("S", StaticSplats[Tensor], DynamicSplats[Tensor])


def rasterize_reference(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View
) -> Render:
    """Render as `hgs_core.render.rasterize` describes.

    Raises:
        InputError: a parameter that is looked at is not finite.
        RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
    """
    camera, gradients = view.camera, view.gradients
    ellipses, rows, dtype = _seen(
        _tracked(static, gradients in ("all", "static")), _tracked(dynamic, gradients in ("all", "dynamic")), view
    )
    pulls = None if view.statistics is None else _pulls(view.statistics, ellipses, rows, gradients, len(static or ()))
    mask = _mask(view, ellipses.means.device)
    image = composite(ellipses, camera.width, camera.height, mask, dtype, view.depth, pulls)
    backdrop = torch.tensor(view.background, dtype=dtype, device=image.device)[:, None, None]
    return Render(image[:3] + (1 - image[3]) * backdrop, image[3], image[4] if view.depth else None)


def contributions_reference(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View
) -> Contributions:
    """Weigh as `hgs_core.render.contributions` describes.

    Raises:
        InputError: a parameter that is looked at is not finite.
        RuntimeError: more than 2^31 - 1 pairs of splats and tiles.
    """
    width, height = view.camera.width, view.camera.height
    with torch.no_grad():
        ellipses, rows, dtype = _seen(static, dynamic, view)
        device = ellipses.means.device
        total = torch.zeros(len(rows), dtype=torch.float64, device=device)
        peak = torch.zeros(len(rows), dtype=dtype, device=device)
        lane = torch.arange(TILE * TILE, device=device)
        across = -(-width // TILE)
        for batch in blend(ellipses, width, height, _mask(view, device), dtype):
            column = (batch.tiles % across * TILE)[:, None] + lane % TILE
            row = (batch.tiles // across * TILE)[:, None] + lane // TILE
            inside = ((column < width) & (row < height))[:, None]  # [B, 1, 256]
            weights = torch.where(inside, batch.weights, 0)
            entry = batch.rows.flatten()
            total.index_add_(0, entry, weights.sum(2, dtype=torch.float64).flatten())
            peak.scatter_reduce_(0, entry, weights.amax(2).flatten(), "amax")
        count = len(static or ()) + len(dynamic or ())
        sums = torch.zeros(count, dtype=torch.float32)
        sums[rows] = total.float().cpu()
        peaks = torch.zeros(count, dtype=torch.float32)
        peaks[rows] = peak.float().cpu()
        return Contributions(sums.numpy(), peaks.numpy())


def _tracked(splats: S | None, wanted: bool) -> S | None:
    return splats if wanted or splats is None else splats.map(Tensor.detach)


def _seen(
    static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, view: View
) -> tuple[Ellipses, Tensor, torch.dtype]:
    """Return the splats on the screen, their rows (statics, then dynamics), and the type of the pixels."""
    refuse_non_finite(static, dynamic, view.time)
    if static is None and dynamic is None:
        static = StaticSplats.empty().map(torch.from_numpy)
    moments, rows, dtype = [], [], torch.float32
    if static is not None:
        moments.append(moment_of_static(static))
        rows.append(torch.arange(len(static)))
        dtype = torch.promote_types(dtype, static.rgb.dtype)
    if dynamic is not None:
        living = torch.nonzero(alive(dynamic, view.time))[:, 0]
        moments.append(moment_of_dynamic(dynamic.map(lambda array: array[living]), view.time))
        rows.append(living.cpu() + len(static or ()))
        dtype = torch.promote_types(dtype, dynamic.rgb.dtype)
    names = [field.name for field in dataclasses.fields(Moment)]
    moment = Moment(*(torch.cat([getattr(m, name) for m in moments]) for name in names))
    ellipses = project(moment, view.camera, view.antialiased, view.rig)
    return ellipses, torch.cat(rows)[ellipses.index.cpu()], dtype


def _mask(view: View, device: torch.device) -> Tensor | None:
    return None if view.tile_mask is None else torch.as_tensor(view.tile_mask, device=device)


def _pulls(
    statistics: ScreenStatistics, ellipses: Ellipses, rows: Tensor, gradients: str, statics: int
) -> Tensor | None:
    """Return a place for `composite`'s pulls; the statistics grow once all pixels have pulled."""
    if gradients == "none" or not ellipses.means.requires_grad:
        return None
    pulls = torch.zeros((len(rows), 2), dtype=torch.float64, device=ellipses.means.device)
    wanted = (rows < statics) if gradients == "static" else (rows >= statics) if gradients == "dynamic" else rows >= 0

    def add(_: Tensor) -> None:
        kept, norms = rows[wanted].numpy(), pulls.cpu().norm(dim=1)[wanted].numpy()
        pulls.zero_()  # a picture may be differentiated again
        statistics.pull_sum[kept] += norms
        statistics.count[kept] += norms > 0

    ellipses.means.register_hook(add)  # type: ignore[no-untyped-call]
    return pulls
