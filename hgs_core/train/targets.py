"""The pictures that training compares with: frames of a capture as float planes, resized."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d, interpolate

from hgs_core.capture.capture import Capture
from hgs_core.render.types import WHOLE, Window
from hgs_core.scene.camera import Camera

__all__ = ["as_target", "target_picture"]

Pixels = TypeVar("Pixels", npt.NDArray[np.uint8], Tensor)


def target_picture(capture: Capture, camera: int, frame: int, size: Camera, window: Window = WHOLE) -> Tensor:
    """Return a frame, or a window of it, as [3, H, W] float32 in [0, 1], area-averaged to the size of `size`."""
    return _sized(capture.frame(camera, frame), _planes_of_array, size, window)


def as_target(pixels: Tensor, size: Camera, window: Window = WHOLE) -> Tensor:
    """Return the same of a frame [H, W, 3] uint8, on the device where it lies."""
    return _sized(pixels, _planes_of_tensor, size, window)


def _sized(pixels: Pixels, planes: Callable[[Pixels], Tensor], size: Camera, window: Window) -> Tensor:
    """Resize a frame and cut it; where a resized pixel is a whole block of the frame's, the frame is cut first."""
    down, across = pixels.shape[0] // size.height, pixels.shape[1] // size.width
    if (down * size.height, across * size.width) == tuple(pixels.shape[:2]):
        blocks = planes(pixels[_in_blocks(window[0], down), _in_blocks(window[1], across)]).div_(255)
        return blocks if down == across == 1 else avg_pool2d(blocks, (down, across))
    resized = interpolate(planes(pixels).div_(255)[None], (size.height, size.width), mode="area")[0]
    return resized[:, window[0], window[1]]


def _in_blocks(run: slice, side: int) -> slice:
    """Return the pixels of a run of blocks, each `side` pixels long."""
    return slice(*(None if end is None else end * side for end in (run.start, run.stop)))


def _planes_of_array(pixels: npt.NDArray[np.uint8]) -> Tensor:
    # One after the other: a copy of all with their axes moved takes three times as long or more.
    planes = np.empty((3, *pixels.shape[:2]), np.float32)
    for channel, plane in enumerate(planes):
        plane[...] = pixels[..., channel]
    return torch.from_numpy(planes)


def _planes_of_tensor(pixels: Tensor) -> Tensor:
    return pixels.permute(2, 0, 1).to(torch.float32, memory_format=torch.contiguous_format)
