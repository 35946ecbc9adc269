"""Changes between successive pictures of one camera, at a small size: motion energy, stillness, blank pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image

__all__ = ["Picture", "PictureChanges", "picture_changes", "same_picture", "watched_frames"]

_SIZE = (128, 96)  # pixels
_NOISE = 6.0  # levels
_BORDER = 3  # pixels
_FIRST = 90  # frames
_LATER = 32  # frames

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Picture = Callable[[int], npt.NDArray[np.uint8]]
"""The picture [H, W, 3] of a camera at a frame."""


@dataclass(frozen=True)
class PictureChanges:
    """Measurements of N pictures of one camera, and of the N - 1 changes from each to the next."""

    frames: npt.NDArray[np.int64]  # [N] increasing
    level: Floats  # [N] mean grey level, 0..255
    spread: Floats  # [N] standard deviation of the grey level
    energy: Floats  # [N - 1] mean levels beyond noise
    mean: Floats  # [N - 1] mean levels, noise included
    floor: Floats  # [N - 1] median levels: noise alone, where less than half of the picture moves
    inside: Bools  # [N - 1] a change beyond noise, none of it at the picture's border

    @property
    def count(self) -> int:
        """How many frames the camera has: the last is always measured."""
        return int(self.frames[-1]) + 1


def watched_frames(count: int) -> npt.NDArray[np.int64]:
    """Return the frames of a capture of `count` to compare: all of the first 90, then 32 spread over the rest."""
    first = np.arange(min(count, _FIRST))
    later = np.linspace(_FIRST, count - 1, min(_LATER, count - _FIRST)) if count > _FIRST else np.zeros(0)
    return np.concatenate((first, later.round())).astype(np.int64)


def picture_changes(picture: Picture, frames: Sequence[int] | npt.NDArray[np.int64]) -> PictureChanges:
    """Measure the pictures [H, W, 3] of one camera at `frames`, each against the one before."""
    level, spread, energy, mean, floor, inside = [], [], [], [], [], []
    before = None
    for frame in frames:
        now = _reduced(picture(int(frame)))
        level.append(float(now.mean()))
        spread.append(float(now.std()))
        if before is not None:
            change = np.abs(now - before)
            moved = change > _NOISE
            energy.append(float(np.where(moved, change, 0).mean()))
            mean.append(float(change.mean()))
            floor.append(float(np.median(change)))
            within = int(moved[_BORDER:-_BORDER, _BORDER:-_BORDER].sum())
            inside.append(0 < within == int(moved.sum()))
        before = now
    return PictureChanges(
        np.array(frames, np.int64),
        np.array(level),
        np.array(spread),
        np.array(energy),
        np.array(mean),
        np.array(floor),
        np.array(inside, bool),
    )


def same_picture(picture: Picture, one: int, other: int) -> bool:
    """Return whether two frames of a camera differ by no more than noise."""
    return bool(np.abs(_reduced(picture(one)) - _reduced(picture(other))).max() <= _NOISE)


def _reduced(picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    grey = Image.fromarray(picture).convert("L").resize(_SIZE, Image.Resampling.BOX)
    return np.asarray(grey, np.float32)
