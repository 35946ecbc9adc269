"""Motion in the pictures of one fixed camera, from their statistics over time.

The background of a pixel is its median over frames spread evenly over time, which anything that stands at a place for
less than half of them does not touch. A pixel moves in a frame where it differs from its background by more than the
noise there, once the frame has the background's exposure. Where it does so in half of the frames, no state is the
background, and it moves in all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.decompose.exposure import compensated
from hgs_core.decompose.morphology import box_sum, close, despeckle, dilate

__all__ = [
    "SAMPLED_FRAMES",
    "Background",
    "Frame",
    "estimate_background",
    "median_picture",
    "moving_pixels",
    "sample_frames",
]

SAMPLED_FRAMES = 25  # frames that the median and the noise are taken from
_STRIP_ROWS = 64  # rows at a time, so that the median needs little memory
_LARGE_PICTURE = 1 << 19  # pixels; larger pictures are judged at half resolution, which their noise and details allow
_MAX_RADIUS = 3  # pixels; of the window that differences are averaged over
_SMOOTHED_NOISE = 1.5  # levels of 255: the window grows until noise averages out to less
_DEVIATION_PER_MEDIAN = 0.79  # standard deviations per median of the largest of three Gaussian sizes: 1 / 1.265
_NOISE_FACTOR = 4.5  # standard deviations of the smoothed difference that count as motion
_NOISE_FLOOR = 5.0  # levels of 255 that no threshold goes below: slow drift and quantisation
_NOISE_SPAN = 1.75  # a pixel's own threshold is at most this much above the picture's, or motion would hide itself
_TEXTURE_SHARE = 0.16  # share of the local contrast: coding errors follow it, and jump at key frames
_RESTLESS_SHARE = 0.5  # share of the frames that differ, from which on there is no background
_MARGIN_PIXELS = 2  # pixels added around what was seen to move, for soft borders

Frame = Callable[[int], npt.NDArray[np.uint8]]
"""Gives the picture [H, W, 3] of a frame."""


@dataclass(frozen=True)
class Background:
    """The still picture behind one camera's video, at the resolution the video is judged at."""

    rgb: npt.NDArray[np.uint8]  # [h, w, 3] median over time
    threshold: npt.NDArray[np.float32]  # [h, w] smoothed difference that counts as motion, levels of 255
    restless: npt.NDArray[np.bool_]  # [h, w] pixels without a background
    halved: bool  # h = H / 2 and w = W / 2, rounded up
    radius: int  # pixels; differences are averaged over (2 radius + 1)^2 pixels: more where there is more noise


def estimate_background(frame: Frame, frames: int) -> Background:
    """Estimate the background from at most 25 of a video's `frames` pictures."""
    chosen = sample_frames(frames, SAMPLED_FRAMES)
    first = frame(chosen[0])
    halved = first.shape[0] * first.shape[1] > _LARGE_PICTURE
    stack = np.stack([_reduced(first, halved), *(_reduced(frame(index), halved) for index in chosen[1:])])  # S pictures
    first_guess = median_picture(stack)
    stack = np.stack([compensated(picture, first_guess) for picture in stack])
    rgb = median_picture(stack)
    radius = _radius(stack, rgb)
    differences = np.stack([_difference(picture, rgb, radius) for picture in stack])  # [S, h, w]
    # The median over time is deaf to what passes by.
    deviation = np.partition(differences, len(chosen) // 2, axis=0)[len(chosen) // 2]
    noise = np.float32(_DEVIATION_PER_MEDIAN) * deviation.astype(np.float32)
    base = max(_NOISE_FLOOR, _NOISE_FACTOR * float(np.median(noise)))  # noise of still pixels, the majority
    texture = np.float32(_TEXTURE_SHARE * 3 / (2 * radius + 1)) * _contrast(rgb)
    threshold = np.clip(_NOISE_FACTOR * noise, base, _NOISE_SPAN * base) + texture
    restless = (differences > threshold).mean(axis=0) > _RESTLESS_SHARE
    return Background(rgb, threshold, restless, halved, radius)


def median_picture(stack: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return the median over S pictures [S, H, W, 3] of one camera, [H, W, 3]."""
    middle = len(stack) // 2
    median: npt.NDArray[np.uint8] = np.empty_like(stack[0])
    for top in range(0, median.shape[0], _STRIP_ROWS):
        median[top : top + _STRIP_ROWS] = np.partition(stack[:, top : top + _STRIP_ROWS], middle, axis=0)[middle]
    return median


def moving_pixels(picture: npt.NDArray[np.uint8], background: Background) -> npt.NDArray[np.bool_]:
    """Return the motion mask [H, W] of a picture [H, W, 3]: objects, their shadows and reflections."""
    exposed = compensated(_reduced(picture, background.halved), background.rgb)
    differs = _difference(exposed, background.rgb, background.radius) > background.threshold
    moving = despeckle(differs | background.restless, 2, 0.3)
    moving = dilate(close(moving, 3), _MARGIN_PIXELS)
    if background.halved:
        moving = moving.repeat(2, axis=0).repeat(2, axis=1)[: picture.shape[0], : picture.shape[1]]
    return moving


def sample_frames(frames: int, count: int) -> Sequence[int]:
    """Return at most `count` frame numbers, spread evenly over time, ascending."""
    return sorted({int(i) for i in np.linspace(0, frames - 1, min(frames, count)).round()})


def _radius(stack: npt.NDArray[np.uint8], rgb: npt.NDArray[np.uint8]) -> int:
    """Return the radius of the window in which the noise of S pictures [S, h, w, 3] averages out."""
    sizes = np.abs(stack[:, ::4, ::4].astype(np.int16) - rgb[::4, ::4])
    noise = 1.4826 * float(np.median(np.median(sizes, axis=0)))
    return int(np.clip(np.ceil((noise / _SMOOTHED_NOISE - 1) / 2), 1, _MAX_RADIUS))


def _difference(
    picture: npt.NDArray[np.uint8], background: npt.NDArray[np.uint8], radius: int
) -> npt.NDArray[np.float32]:
    """Return the largest channel of the smoothed difference of two pictures [h, w, 3], levels of 255, [h, w].

    The mean over the window is taken with the sign: noise cancels, motion and shadows do not.
    """
    signed = picture.astype(np.int16) - background
    red, green, blue = np.moveaxis(np.abs(box_sum(signed, radius)), 2, 0)
    largest = np.maximum(np.maximum(red, green), blue)  # many times as fast as the maximum over an axis of three
    return np.asarray(largest, np.float32) * np.float32(1 / (2 * radius + 1) ** 2)


def _contrast(picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    """Return the mean difference of neighbouring pixels around each pixel of a picture [h, w, 3], [h, w]."""
    wide = picture.astype(np.int16)
    steps = np.zeros(picture.shape[:2], np.int16)
    steps[:, 1:] += np.abs(wide[:, 1:] - wide[:, :-1]).max(axis=2)
    steps[1:] += np.abs(wide[1:] - wide[:-1]).max(axis=2)
    return np.asarray(box_sum(steps, 1), np.float32) * np.float32(1 / 9)


def _reduced(picture: npt.NDArray[np.uint8], halved: bool) -> npt.NDArray[np.uint8]:
    """Return the mean of every 2x2 block, if wanted; an odd last row or column stands for itself."""
    if not halved:
        return picture
    padded = np.pad(picture, ((0, picture.shape[0] % 2), (0, picture.shape[1] % 2), (0, 0)), mode="edge")
    wide = padded.astype(np.uint16)
    total = wide[::2, ::2] + wide[1::2, ::2] + wide[::2, 1::2] + wide[1::2, 1::2]
    return np.asarray((total + 2) >> 2, np.uint8)
