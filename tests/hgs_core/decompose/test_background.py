"""Automatic masks on synthetic videos of known motion, and on the sample against the renderer's object masks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.capture.open import open_capture
from hgs_core.decompose.background import estimate_background, moving_pixels, sample_frames
from hgs_core.decompose.morphology import dilate


def video(height: int, width: int, *, noise: float, square: bool) -> np.ndarray:
    """30 frames [30, H, W, 3] of a still texture with noise, and perhaps a square of 12 pixels that crosses it."""
    numbers = np.random.default_rng(0)
    texture = numbers.integers(60, 190, (height // 8, width // 8, 3)).repeat(8, 0).repeat(8, 1)
    frames = texture + numbers.normal(0, noise, (30, height, width, 3))
    if square:
        for index in range(30):
            frames[index, 20:32, 2 * index : 2 * index + 12] = (250, 20, 20)
    return frames.clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize("noise", [0.0, 2.0, 6.0])
def test_noise_does_not_move(noise: float) -> None:
    frames = video(64, 96, noise=noise, square=False)
    background = estimate_background(lambda index: frames[index], 30)
    assert np.mean([moving_pixels(frame, background).mean() for frame in frames]) < 0.01


@pytest.mark.parametrize("noise", [0.0, 4.0])
def test_a_crossing_square_is_found_and_little_else(noise: float) -> None:
    frames = video(64, 96, noise=noise, square=True)
    background = estimate_background(lambda index: frames[index], 30)
    for index in (0, 10, 29):
        truth = np.zeros((64, 96), bool)
        truth[20:32, 2 * index : 2 * index + 12] = True
        mask = moving_pixels(frames[index], background)
        assert mask[truth].mean() > 0.97
        assert mask[~dilate(truth, 5)].mean() < 0.02


def test_a_soft_shadow_moves() -> None:
    frames = video(64, 96, noise=2.0, square=False)
    frames[10:14, 30:50, 40:70] = (frames[10:14, 30:50, 40:70] * 0.8).astype(np.uint8)
    background = estimate_background(lambda index: frames[index], 30)
    assert moving_pixels(frames[12], background)[32:48, 42:68].mean() > 0.9
    assert moving_pixels(frames[20], background).mean() < 0.01


def test_what_never_rests_always_moves() -> None:
    frames = video(64, 96, noise=1.0, square=False)
    frames[:, 20:40, 20:40] = np.random.default_rng(1).integers(0, 255, (30, 4, 4, 3)).repeat(5, 1).repeat(5, 2)
    background = estimate_background(lambda index: frames[index], 30)
    assert all(moving_pixels(frame, background)[20:40, 20:40].mean() > 0.95 for frame in frames)


def test_large_pictures_are_judged_at_half_size() -> None:
    frames = np.full((9, 741, 735, 3), 100, np.uint8)  # odd sides
    for index in range(9):
        frames[index, 20:40, 60 * index : 60 * index + 20] = (250, 20, 20)
    background = estimate_background(lambda index: frames[index], 9)
    mask = moving_pixels(frames[5], background)
    assert background.halved
    assert mask.shape == (741, 735)
    assert mask[20:40, 300:320].all()
    assert mask.mean() < 0.01


def test_one_frame_does_not_move() -> None:
    frames = video(64, 96, noise=2.0, square=True)
    assert not moving_pixels(frames[0], estimate_background(lambda index: frames[index], 1)).any()


def test_sampled_frames_are_spread_evenly() -> None:
    assert list(sample_frames(60, 4)) == [0, 20, 39, 59]
    assert list(sample_frames(3, 25)) == [0, 1, 2]


def test_the_sample_s_moving_objects_are_found() -> None:
    """Truth: the renderer's object masks (without shadows and reflections, which double the moving area)."""
    capture = open_capture(Path(__file__).resolve().parents[3] / "samples" / "studio")
    with np.load(Path(__file__).parent / "studio_truth.npz") as file:
        truth = np.unpackbits(file["bits"], count=int(file["shape"].prod())).reshape(file["shape"]).astype(bool)
        cameras, numbers = file["cameras"], file["frames"]
    for camera, rows in zip(cameras, truth, strict=True):
        background = estimate_background(lambda frame, camera=camera: capture.frame(int(camera), frame), 60)
        found = np.stack([moving_pixels(capture.frame(int(camera), int(frame)), background) for frame in numbers])
        wider = np.stack([dilate(mask, 1) for mask in rows])
        assert found[wider].mean() > 0.92
        assert rows.mean() < found.mean() < 0.22
