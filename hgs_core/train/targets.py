"""The pictures that training compares with: frames of a capture as float planes, resized."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import interpolate

from hgs_core.camera import Camera
from hgs_core.capture.capture import Capture

__all__ = ["target_picture"]


def target_picture(capture: Capture, camera: int, frame: int, size: Camera) -> Tensor:
    """Return a frame as [3, H, W] float32 in [0, 1], area-averaged to the size of the camera `size`."""
    # The frame is read-only; the conversion to float copies it.
    pixels = torch.frombuffer(capture.frame(camera, frame).data, dtype=torch.uint8)
    full = capture.cameras[camera]
    picture = pixels.view(full.height, full.width, 3).permute(2, 0, 1).to(torch.float32).div_(255)
    if (size.height, size.width) == (full.height, full.width):
        return picture.contiguous()
    return interpolate(picture[None], (size.height, size.width), mode="area")[0]
