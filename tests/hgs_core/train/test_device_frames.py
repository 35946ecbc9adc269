"""Frames on the CPU; those of a CUDA device need one (tests/hgs_core/render/triton/test_on_cuda.py runs there)."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from hgs_core.capture.capture import Capture
from hgs_core.train.device_frames import DeviceFrames
from hgs_core.train.targets import target_picture

needs_cuda = pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device")


def test_the_cpu_gets_the_captures_own_pictures(capture: Capture) -> None:
    half = replace(capture.cameras[2], width=20, height=15)
    frames = DeviceFrames(capture, torch.device("cpu"), 0)
    assert torch.equal(frames.target(2, 1, half), target_picture(capture, 2, 1, half))


@needs_cuda
@pytest.mark.parametrize("frames_kept", [0, 2, 100])
def test_a_device_keeps_as_many_frames_as_fit_and_gives_the_same_pictures(capture: Capture, frames_kept: int) -> None:
    size = capture.cameras[0].width * capture.cameras[0].height * 3
    frames = DeviceFrames(capture, torch.device("cuda"), frames_kept * size)
    for camera, frame in ((0, 0), (1, 1), (0, 0), (2, 2), (1, 1)):
        target = frames.target(camera, frame, capture.cameras[camera])
        torch.testing.assert_close(target.cpu(), target_picture(capture, camera, frame, capture.cameras[camera]))
        assert len(frames._kept) <= frames_kept
