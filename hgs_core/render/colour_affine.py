"""Affine colour correction of a rendered picture: the cameras of a capture seldom agree on exposure and white balance.

Training only: a correction belongs to one camera of the capture. Scenes, the codec and viewers know nothing of it.
"""

from __future__ import annotations

import torch
from torch import Tensor

from hgs_core.base.errors import InputError

__all__ = ["colour_affine", "identity_affine"]


def identity_affine(cameras: int, dtype: torch.dtype = torch.float32) -> Tensor:
    """Return corrections [cameras, 3, 4] that change nothing: rows of `[A | b]` with A = I and b = 0."""
    return torch.eye(3, 4, dtype=dtype).repeat(cameras, 1, 1)


def colour_affine(picture: Tensor, affine: Tensor) -> Tensor:
    """Return `A rgb + b` of every pixel, differentiable towards both arguments.

    Args:
        picture: [3, H, W] display-referred sRGB.
        affine: [3, 4], `[A | b]`; b in units of colour.

    Raises:
        InputError: arrays of other shapes.
    """
    if picture.dim() != 3 or picture.shape[0] != 3:
        raise InputError("picture", f"shape {tuple(picture.shape)}", "give planes [3, H, W]")
    if affine.shape != (3, 4):
        raise InputError("affine", f"shape {tuple(affine.shape)}", "give one camera's correction, [3, 4]")
    pixels = affine[:, :3] @ picture.flatten(1) + affine[:, 3:]
    return pixels.view_as(picture)
