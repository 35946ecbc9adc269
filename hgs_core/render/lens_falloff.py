"""Light falloff of a lens: a picture is darker the farther from its middle.

Training and scoring only: it belongs to a camera of the capture. Scenes, the codec and viewers know nothing of it.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.scene.camera import Camera

__all__ = ["falloff_gain"]


def falloff_gain(falloff: Tensor, camera: Camera) -> Tensor:
    """Return the gain [H, W] of every pixel, 1 + a r^2 + b r^4, differentiable towards the coefficients.

    An even polynomial of the radius is the usual model of vignetting (Goldman and Chen, "Vignette and Exposure
    Calibration and Compensation", ICCV 2005). Ours has two terms.

    Args:
        falloff: [2], a and b.
        camera: at the size of the picture. r is the distance to its principal point in halves of the diagonal.

    Raises:
        InputError: an array of another shape.
    """
    if falloff.shape != (2,):
        raise InputError("falloff", f"shape {tuple(falloff.shape)}", "give one camera's two coefficients, [2]")
    half = math.hypot(camera.width, camera.height) / 2
    across = (torch.arange(camera.width, device=falloff.device) + 0.5 - camera.cx) / half
    down = (torch.arange(camera.height, device=falloff.device) + 0.5 - camera.cy) / half
    squares = (down.square()[:, None] + across.square()).to(falloff.dtype)
    return 1 + squares * (falloff[0] + falloff[1] * squares)
