from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

from hgs_core.capture.capture import Capture
from hgs_core.train.targets import as_target, target_picture


def test_a_target_is_the_frame_between_0_and_1(capture: Capture) -> None:
    camera, frame = capture.cameras[1], capture.frame(1, 2)
    target = target_picture(capture, 1, 2, camera)
    assert target.dtype == torch.float32
    np.testing.assert_allclose(target.numpy(), frame.transpose(2, 0, 1) / 255, atol=1e-7)


def test_a_smaller_target_is_the_mean_over_areas(capture: Capture) -> None:
    """Reference: the mean of every block of 2x2 pixels."""
    camera, frame = capture.cameras[0], capture.frame(0, 0)
    half = replace(camera, width=camera.width // 2, height=camera.height // 2)
    height, width = frame.shape[0] // 2, frame.shape[1] // 2
    blocks = frame.reshape(height, 2, width, 2, 3).mean((1, 3)).transpose(2, 0, 1) / 255
    np.testing.assert_allclose(target_picture(capture, 0, 0, half).numpy(), blocks, atol=1e-6)


def test_pixels_on_a_device_give_the_same_bits(capture: Capture) -> None:
    camera = capture.cameras[0]
    for size in (camera, replace(camera, width=20, height=15)):
        made = as_target(torch.tensor(capture.frame(0, 3)), size)
        assert torch.equal(made, target_picture(capture, 0, 3, size))


@pytest.mark.parametrize("reduced", [False, True])
def test_a_window_is_a_part_of_the_picture(capture: Capture, reduced: bool) -> None:
    camera = capture.cameras[0]
    size = replace(camera, width=20, height=15) if reduced else camera
    window = slice(3, 12), slice(5, 18)
    part = target_picture(capture, 0, 3, size)[:, 3:12, 5:18]
    assert part.shape == (3, 9, 13)
    assert torch.equal(target_picture(capture, 0, 3, size, window), part)
    assert torch.equal(as_target(torch.tensor(capture.frame(0, 3)), size, window), part)
