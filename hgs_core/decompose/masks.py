"""The motion masks of a capture: given ones where it has them, automatic ones elsewhere."""

from __future__ import annotations

import dataclasses
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.decompose.automatic_masks import automatic_masks
from hgs_core.decompose.background import sample_frames
from hgs_core.decompose.mask_segment import MaskSegment, packed_mask, unpacked_mask

__all__ = ["MotionMasks", "kept_masks", "mask_file", "motion_masks"]

_SHARE_FRAMES = 16  # frames of each camera for the estimate of `MotionMasks.share`
_MOST_MAPPED = 8  # files open at once
_MOST_GIVEN = 4096  # given masks kept, some 2 KiB each at 640x360


def mask_file(folder: Path, segment: int) -> Path:
    """Return the file of a segment's automatic masks."""
    return folder / f"{segment}.masks"


class MotionMasks:
    """One mask per training picture, kept as deflated bits.

    Given masks are read when asked for. Those asked for last are kept: training asks for each many times, and a file
    takes twenty times as long.
    """

    def __init__(self, capture: Capture, cameras: Sequence[int], segment: Callable[[int], MaskSegment]) -> None:
        """Take the automatic masks of a frame from `segment(frame)`; `motion_masks` and `load` call this."""
        self.cameras = tuple(cameras)
        self._capture = capture
        self._segment = segment
        self._given = lru_cache(_MOST_GIVEN)(self._read_given)

    def mask(self, camera: int, frame: int) -> npt.NDArray[np.bool_]:
        """Return the mask [H, W], True = moves.

        Raises:
            InputError: a given mask is unreadable, or the file of automatic ones is missing or damaged.
            IndexError: no masks were made for this camera, or no such frame.
        """
        if camera not in self.cameras:
            raise IndexError(f"no masks were made for camera {camera}")
        size = self._capture.cameras[camera]
        shape = size.height, size.width
        segment = self._segment(frame)
        if camera in segment.rows:
            return segment.mask(camera, frame, shape)
        return unpacked_mask(self._given(camera, frame), shape)

    def _read_given(self, camera: int, frame: int) -> bytes:
        given = self._capture.mask(camera, frame)
        if given is None:
            raise InputError(self._capture.path, f"the masks of camera {camera} are gone", "restore the files")
        return packed_mask(given)

    def share(self) -> float:
        """Return the share of the pixels that move, 0..1, from at most 16 frames of each camera."""
        frames = sample_frames(len(self._capture.times), _SHARE_FRAMES)
        return float(np.mean([self.mask(camera, frame).mean() for camera in self.cameras for frame in frames]))

    def changed(self, change: Callable[[int, int, npt.NDArray[np.bool_]], npt.NDArray[np.bool_]]) -> MotionMasks:
        """Return masks that `change(camera, frame, mask)` puts in the place of these, given ones too."""
        frames = range(len(self._capture.times))
        rows = {c: [packed_mask(change(c, frame, self.mask(c, frame))) for frame in frames] for c in self.cameras}
        whole = MaskSegment(frames, rows)
        return MotionMasks(self._capture, self.cameras, lambda frame: whole)

    def save(self, folder: Path, starts: Sequence[int]) -> None:
        """Write the automatic masks, a file for each of the segments that begin at the frames `starts`."""
        for number, frames in enumerate(_frames_of_files(starts, len(self._capture.times))):
            automatic = [camera for camera in self.cameras if camera in self._segment(frames.start).rows]
            rows = {c: [self._segment(frame).packed(c, frame) for frame in frames] for c in automatic}
            MaskSegment(frames, rows).save(mask_file(folder, number), self._capture.fingerprint())

    @classmethod
    def load(cls, folder: Path, capture: Capture, cameras: Sequence[int], starts: Sequence[int]) -> MotionMasks:
        """Return the masks in a folder, of segments that begin at the frames `starts`; given ones are the capture's.

        A segment's file is opened when a frame of it is asked for: the others may be missing.
        """

        @lru_cache(_MOST_MAPPED)
        def loaded(number: int) -> MaskSegment:
            return MaskSegment.load(mask_file(folder, number), capture.fingerprint())

        def segment(frame: int) -> MaskSegment:
            own = bisect_right(starts, frame) - 1
            if not mask_file(folder, own).exists():  # a neighbour's file may have it too
                for number in (own - 1, own + 1):
                    if mask_file(folder, number).exists() and frame in loaded(number).frames:
                        return loaded(number)
            return loaded(own)

        return cls(capture, cameras, segment)


def motion_masks(capture: Capture, cameras: Sequence[int], *, progress: ProgressCallback) -> MotionMasks:
    """Return the motion masks of the given cameras; no other camera is read. At a single moment nothing moves.

    Raises:
        InputError: a picture is missing or unreadable.
        StageStopped: the callback wishes so.
    """
    frames = range(len(capture.times))
    (whole,) = automatic_masks(capture, _without_masks(capture, cameras), [frames], progress)
    return MotionMasks(capture, cameras, lambda frame: whole)


def kept_masks(
    folder: Path, capture: Capture, cameras: Sequence[int], starts: Sequence[int], *, progress: ProgressCallback
) -> MotionMasks:
    """Return the motion masks of the given cameras, after making the files that the folder lacks.

    There is one for each of the segments that begin at the frames `starts`. It is written as soon as it is made, and
    kept if it is there. The bits are the same in any case.

    Raises:
        InputError: a picture is missing or unreadable.
        StageStopped: the callback wishes so.
    """
    frames = _frames_of_files(starts, len(capture.times))
    missing = [number for number in range(len(starts)) if not mask_file(folder, number).exists()]
    if missing:
        wanted = _without_masks(capture, cameras)
        there = len(wanted) * (len(capture.times) - len(set().union(*(frames[number] for number in missing))))

        def report(step: Progress) -> None:
            progress(dataclasses.replace(step, done=there + step.done, total=there + step.total))

        made = automatic_masks(capture, wanted, [frames[number] for number in missing], report)
        for number, segment in zip(missing, made, strict=True):
            segment.save(mask_file(folder, number), capture.fingerprint())
    return MotionMasks.load(folder, capture, cameras, starts)


def _frames_of_files(starts: Sequence[int], frames: int) -> list[range]:
    """Return the frames of each segment's file: its own and one on either side, which a camera out of step needs."""
    return [range(max(0, start - 1), min(frames, end + 1)) for start, end in pairwise([*starts, frames])]


def _without_masks(capture: Capture, cameras: Sequence[int]) -> list[int]:
    return [camera for camera in cameras if capture.mask(camera, 0) is None]
