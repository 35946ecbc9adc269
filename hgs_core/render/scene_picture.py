"""A picture of a whole scene at a second, drawn as the scene asks for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.render.rasterize import rasterize
from hgs_core.render.types import Render
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["pixels_of", "scene_picture"]


def scene_picture(
    scene: HybridScene[Tensor],
    camera: Camera,
    seconds: float,
    *,
    rig: Sequence[Camera] = (),
    backend: str = "auto",
    depth: bool = False,
) -> Render:
    """Return the picture of a scene from a camera, with its background and antialiasing and without gradients.

    `rig`, `backend` and `depth` are those of `rasterize`, as are the errors raised.
    """
    segment = scene.segment_at(seconds)
    return rasterize(
        scene.static,
        segment.dynamic,
        camera,
        segment.normalised(seconds),
        background=scene.background,
        backend=backend,
        gradients="none",
        antialiased=scene.antialiased,
        depth=depth,
        rig=rig,
    )


def pixels_of(planes: Tensor) -> npt.NDArray[np.uint8]:
    """Return a picture [channels, H, W] as 8-bit pixels [H, W, channels]; values are limited to 0 to 1."""
    levels = (planes.clamp(0, 1) * 255).round().to(torch.uint8)
    return np.ascontiguousarray(levels.permute(1, 2, 0).cpu().numpy())
