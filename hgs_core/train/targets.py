"""The pictures that training compares with: frames of a capture as float planes, resized."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import interpolate

from hgs_core.capture.capture import Capture
from hgs_core.scene.camera import Camera

__all__ = ["as_target", "target_picture"]


def target_picture(capture: Capture, camera: int, frame: int, size: Camera) -> Tensor:
    """Return a frame as [3, H, W] float32 in [0, 1], area-averaged to the size of the camera `size`."""
    planes = np.ascontiguousarray(capture.frame(camera, frame).transpose(2, 0, 1), dtype=np.float32)
    return _resized(torch.from_numpy(planes).div_(255), size)


def as_target(pixels: Tensor, size: Camera) -> Tensor:
    """Return the same of a frame [H, W, 3] uint8, on the device where it lies."""
    return _resized(pixels.permute(2, 0, 1).to(torch.float32, memory_format=torch.contiguous_format).div_(255), size)


def _resized(picture: Tensor, size: Camera) -> Tensor:
    if picture.shape[1:] == (size.height, size.width):
        return picture
    return interpolate(picture[None], (size.height, size.width), mode="area")[0]
