"""The one way to draw splats, with any backend."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt
from torch import Tensor

from hgs_core.render.backends import Backend, choose_backend
from hgs_core.render.cpu import rasterize_cpu
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import Gradients, Render, ScreenStatistics, View
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["rasterize", "rasterizer"]


def rasterize(
    static: StaticSplats[Tensor] | None,
    dynamic: DynamicSplats[Tensor] | None,
    camera: Camera,
    time: float = 0.0,
    *,
    background: Sequence[float] = (0.0, 0.0, 0.0),
    backend: str = "auto",
    gradients: Gradients = "all",
    tile_mask: npt.NDArray[np.bool_] | None = None,
    statistics: ScreenStatistics | None = None,
    antialiased: bool = False,
    depth: bool = False,
    rig: Sequence[Camera] = (),
) -> Render:
    """Draw static and dynamic splats as `camera` sees them at one moment.

    Args:
        static: splats that are always there, or None.
        dynamic: splats evaluated at `time`, or None.
        camera: the view and the size of the picture.
        time: normalised time of the dynamic splats' segment.
        background: colour behind everything, sRGB in [0, 1].
        backend: "reference" (torch, any dtype and device), "cpu" (compiled, float32), "triton" (CUDA, float32), or
            "auto" (`choose_backend`).
        gradients: which parameters the backward pass reaches; the others cost nothing.
        tile_mask: [ceil(H/16), ceil(W/16)]; tiles that are False are not drawn: they show the background.
        statistics: is added to when the backward pass runs; rows are statics, then dynamics.
        antialiased: fade splats thinner than the low-pass by as much as it widens them (docs/numerics.md,
            "Antialiasing").
        depth: also return the depth, weighted like the colour and without a background.
        rig: cameras of the pictures that made the splats, at their size: where this picture is larger, splats are as
            soft as there (docs/numerics.md, "Magnification"). Without it they may be as thin as a pixel of this one.

    Returns:
        The picture and its coverage, differentiable towards the parameters that require gradients.

    Raises:
        InputError: an unknown backend or one that cannot run here, an unknown gradient set, a mask of another shape, or
            a parameter that is not finite.
        RuntimeError: more than 2^31 - 1 pairs of splats and tiles.

    Example:
        >>> import hgs_core as hgs
        >>> import torch
        >>> from pathlib import Path
        >>> rig = hgs.load_manifest(Path("run/scene")).cameras
        >>> scene = hgs.decode_scene(Path("run/scene")).map(torch.from_numpy)
        >>> segment = scene.segment_at(scene.start)
        >>> picture = hgs.rasterize(
        ...     scene.static, segment.dynamic, rig[0], segment.normalised(scene.start),
        ...     background=scene.background, antialiased=scene.antialiased, rig=rig,
        ... )
        >>> picture.rgb.shape  # sRGB, not clamped: channels, height, width
        torch.Size([3, 48, 64])
    """
    red, green, blue = background
    behind = (red, green, blue)
    view = View(camera, time, behind, tile_mask, antialiased, depth, gradients, statistics, tuple(rig))
    return rasterizer(choose_backend(backend, static, dynamic))(static, dynamic, view)


def rasterizer(
    backend: Backend,
) -> Callable[[StaticSplats[Tensor] | None, DynamicSplats[Tensor] | None, View], Render]:
    """Return the function by which a backend draws."""
    if backend == "triton":
        from hgs_core.render.triton.rasterize import rasterize_triton

        return rasterize_triton
    return rasterize_cpu if backend == "cpu" else rasterize_reference
