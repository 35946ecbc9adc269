"""The colours of a picture as a camera shows them: its lens darkens corners, its sensor has its own white balance.

Training only: both belong to one camera of the capture. Scenes, the codec and viewers know nothing of them.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.native import library
from hgs_core.native.camera_colours import LensAxis, camera_shown, camera_shown_backward
from hgs_core.render.colour_affine import colour_affine
from hgs_core.render.lens_falloff import falloff_gain
from hgs_core.render.types import WHOLE, Window
from hgs_core.scene.camera import Camera

__all__ = ["camera_colours", "camera_colours_pulled"]


def camera_colours(
    picture: Tensor, affine: Tensor, falloff: Tensor | None, camera: Camera, window: Window = WHOLE
) -> Tensor:
    """Return `A (gain rgb) + b` of every pixel of a picture or of a window of it, differentiable towards all tensors.

    Float32 pictures on the CPU use the compiled kernel where there is one.

    Args:
        picture: [3, h, w] display-referred sRGB, the window.
        affine: [3, 4], `[A | b]` (`colour_affine`).
        falloff: [2], coefficients of the lens's gain (`falloff_gain`); None: it darkens nothing.
        camera: at the size of the whole picture.
        window: which part of it there is.

    Raises:
        InputError: arrays of other shapes.
    """
    rows, columns = (range(side)[part] for side, part in zip((camera.height, camera.width), window, strict=True))
    expected = {"picture": (picture, (3, len(rows), len(columns))), "affine": (affine, (3, 4))}
    if falloff is not None:
        expected["falloff"] = (falloff, (2,))
    for name, (array, shape) in expected.items():
        if array.shape != shape:
            raise InputError(name, f"shape {tuple(array.shape)}", f"give one of {shape}")
    if picture.device.type == "cpu" and picture.dtype == torch.float32 and library.available():
        lens = _lens_axis(camera, window)
        return _NativeColours.apply(picture, affine, falloff, lens)  # type: ignore[no-any-return,no-untyped-call]
    return colour_affine(picture if falloff is None else picture * falloff_gain(falloff, camera)[window], affine)


def camera_colours_pulled(
    gradient: Tensor,
    picture: Tensor,
    affine: Tensor,
    falloff: Tensor | None,
    camera: Camera,
    window: Window = WHOLE,
) -> Tensor:
    """Return the gradient [3, h, w] of a loss towards `picture`; `gradient` is the one towards `camera_colours` of it.

    The other arguments are those of `camera_colours`. Nothing takes part in autograd.
    """
    if picture.device.type == "cpu" and picture.dtype == torch.float32 and library.available():
        given = (gradient, picture, affine, _coefficients(falloff))
        towards, shown, matrix, gain = (array.detach().contiguous().numpy() for array in given)
        return torch.from_numpy(camera_shown_backward(towards, shown, matrix, gain, _lens_axis(camera, window)).picture)
    own = picture.clone().requires_grad_(True)
    (found,) = torch.autograd.grad(camera_colours(own, affine, falloff, camera, window), own, gradient)
    return found


def _lens_axis(camera: Camera, window: Window) -> LensAxis:
    rows, columns = (range(side)[part] for side, part in zip((camera.height, camera.width), window, strict=True))
    return LensAxis(camera.cx - columns.start, camera.cy - rows.start, math.hypot(camera.width, camera.height) / 2)


def _coefficients(falloff: Tensor | None) -> Tensor:
    return torch.zeros(2) if falloff is None else falloff


class _NativeColours(torch.autograd.Function):
    """The compiled kernel and its derivative."""

    @staticmethod
    def forward(ctx: Any, picture: Tensor, affine: Tensor, falloff: Tensor | None, lens: LensAxis) -> Tensor:
        arguments = [array.detach().contiguous().numpy() for array in (picture, affine, _coefficients(falloff))]
        ctx.arguments = (*arguments, lens)
        return torch.from_numpy(camera_shown(*ctx.arguments))

    @staticmethod
    def backward(ctx: Any, gradient: Tensor) -> tuple[Tensor, Tensor, Tensor | None, None]:
        found = camera_shown_backward(gradient.contiguous().numpy(), *ctx.arguments)
        picture, affine, falloff = (torch.from_numpy(array) for array in found)
        return picture, affine, falloff if ctx.needs_input_grad[2] else None, None
