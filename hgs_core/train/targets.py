"""The pictures that training compares with: frames of a capture as float planes, resized."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import interpolate

from hgs_core.camera import Camera
from hgs_core.capture.capture import Capture

__all__ = ["target_picture"]


def target_picture(capture: Capture, camera: int, frame: int, size: Camera) -> Tensor:
    """Return a frame as [3, H, W] float32 in [0, 1], area-averaged to the size of the camera `size`."""
    planes = np.ascontiguousarray(capture.frame(camera, frame).transpose(2, 0, 1), dtype=np.float32)
    picture = torch.from_numpy(planes).div_(255)
    if picture.shape[1:] == (size.height, size.width):
        return picture
    return interpolate(picture[None], (size.height, size.width), mode="area")[0]
