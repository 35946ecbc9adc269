"""The order of a video's fields, from its pictures: which lines were taken half a frame before the others.

A line is compared with the mean of the two around it, and so is the same line of the frame before and of the frame
after. In whole pictures these two differ from the mean alike. With two fields one of them is nearer in time to the
lines around it, and for the lines between it is the other. No pattern that is still or moves has such a turn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum

import numpy as np
import numpy.typing as npt

from hgs_core.check.picture_changes import PictureChanges

__all__ = ["FieldOrder", "busiest_frames", "field_order"]

_MOVED = 12  # levels
_LEAST_MOVING = 1000  # pixels
_LEAN = 0.15  # share; whole pictures have at most 0.03, two fields 0.25 to 0.5
_FRAMES = 3
_COLUMNS = 640  # enough for a verdict: wider pictures are thinned out

Lines = Callable[[int], npt.NDArray[np.uint8]]
"""The brightness [H, W] of a camera's picture at a frame, as its file has it."""


class FieldOrder(Enum):
    """The order of fields, by FFmpeg's name where there are two."""

    TOP_FIRST = "tff"
    BOTTOM_FIRST = "bff"
    WHOLE = "progressive"


def busiest_frames(changes: PictureChanges) -> tuple[int, ...]:
    """Return the watched frames between two others at which most moves, in order; none where nothing does."""
    within = (changes.frames[1:] > 0) & (changes.frames[1:] < changes.count - 1) & (changes.energy > 0)
    # Between frames far apart the energy does not tell when something moved.
    next_to = within & (np.diff(changes.frames) == 1)
    found = np.flatnonzero(next_to if next_to.any() else within)
    busiest = found[np.argsort(-changes.energy[found], kind="stable")][:_FRAMES]
    return tuple(sorted(int(frame) for frame in changes.frames[1:][busiest]))


def field_order(lines: Lines, frames: Sequence[int]) -> FieldOrder | None:
    """Return the order of fields in a camera's pictures around `frames`; None where too little moves to tell.

    Raises:
        InputError: a picture is missing or unreadable.
    """
    lean, most, moving = 0.0, 0.0, 0
    for frame in frames:
        before, now, after = (_columns(lines(one)) for one in (frame - 1, frame, frame + 1))
        mean = (now[:-2] + now[2:]) / 2
        by_before, by_after = np.abs(before[1:-1] - mean), np.abs(after[1:-1] - mean)
        moved = np.maximum(np.abs(before - now), np.abs(after - now))[1:-1] > _MOVED
        turn = np.where(moved, by_after - by_before, 0)
        lean += float(turn[::2].sum() - turn[1::2].sum())
        most += float(np.maximum(by_before, by_after)[moved].sum())
        moving += int(moved.sum())
    if moving < _LEAST_MOVING or most == 0:
        return None
    if abs(lean) < _LEAN * most:
        return FieldOrder.WHOLE
    return FieldOrder.TOP_FIRST if lean > 0 else FieldOrder.BOTTOM_FIRST


def _columns(lines: npt.NDArray[np.uint8]) -> npt.NDArray[np.float32]:
    return lines[:, :: max(1, lines.shape[1] // _COLUMNS)].astype(np.float32)
