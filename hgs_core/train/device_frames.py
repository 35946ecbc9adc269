"""Frames of a capture where training draws: a device keeps those that fit, as bytes."""

from __future__ import annotations

from collections import OrderedDict

import torch
from torch import Tensor

from hgs_core.capture.capture import Capture
from hgs_core.render.types import WHOLE, Window
from hgs_core.scene.camera import Camera
from hgs_core.train.targets import as_target, target_picture

__all__ = ["DeviceFrames"]


class DeviceFrames:
    """Target pictures on a device.

    A CUDA device keeps frames as uint8, those used last, up to `memory` bytes; others come from the capture's own cache
    through pinned memory. The CPU keeps none: the capture does.
    """

    def __init__(self, capture: Capture, device: torch.device, memory: int) -> None:
        """Keep nothing yet."""
        self._capture, self._device, self._room = capture, device, memory
        self._kept: OrderedDict[tuple[int, int], Tensor] = OrderedDict()  # [H, W, 3] uint8, used last at the end

    def target(self, camera: int, frame: int, size: Camera, window: Window = WHOLE) -> Tensor:
        """Return a frame, or a window of it, as `target_picture` does, on the device."""
        if self._device.type == "cpu":
            return target_picture(self._capture, camera, frame, size, window)
        pixels = self._kept.pop((camera, frame), None)
        if pixels is None:
            pixels = torch.tensor(self._capture.frame(camera, frame)).pin_memory().to(self._device, non_blocking=True)
            self._room -= pixels.numel()
        self._kept[camera, frame] = pixels
        while self._room < 0:
            self._room += self._kept.popitem(last=False)[1].numel()
        return as_target(pixels, size, window)
