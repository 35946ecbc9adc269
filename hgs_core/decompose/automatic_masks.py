"""Automatic masks of several cameras, segment by segment, each given away as soon as it is found."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool, watched
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.decompose.background import (
    SAMPLED_FRAMES,
    Background,
    estimate_background,
    moving_pixels,
    sample_frames,
)
from hgs_core.decompose.mask_segment import MaskSegment, packed_mask

__all__ = ["automatic_masks"]

_STAGE = "masks"
_MOST_BACKGROUNDS = 4  # backgrounds estimated at once: each holds 25 pictures


def automatic_masks(
    capture: Capture, cameras: Sequence[int], segments: Sequence[range], progress: ProgressCallback
) -> Iterator[MaskSegment]:
    """Yield the masks of the cameras for each of the segments, ranges of frames in ascending order.

    The background of a camera is that of the whole capture, whatever the segments are. Frames that a segment shares
    with the one before are not looked at again. At a single moment nothing moves, and no picture is read. Progress
    counts pictures: those of the segments, and at most 25 for each background.

    Raises:
        InputError: a picture is missing or unreadable.
        StageStopped: the callback wishes so.
    """
    frames = len(capture.times)
    if not cameras or frames == 1:
        still = {camera: packed_mask(np.zeros(_shape(capture, camera), bool)) for camera in cameras}
        yield from (MaskSegment(one, {camera: [still[camera]] * len(one) for camera in cameras}) for one in segments)
        return
    seen, unwanted = dict.fromkeys(cameras, 0), threading.Event()  # pictures; each count has one thread at a time
    total = len(cameras) * (len(set().union(*segments)) + len(sample_frames(frames, SAMPLED_FRAMES)))

    def picture(camera: int, frame: int) -> npt.NDArray[np.uint8]:
        if unwanted.is_set():
            raise InterruptedError("the masks are not wanted any more")
        shown = capture.frame(camera, frame)
        seen[camera] += 1
        return shown

    def report() -> None:
        progress(Progress(_STAGE, sum(seen.values()), total))

    def background(camera: int) -> Background:
        return estimate_background(partial(picture, camera), frames)

    report()
    with core_pool(_MOST_BACKGROUNDS) as pool:
        backgrounds = watched({one: pool.submit(background, one) for one in cameras}, report, unwanted)
    before = MaskSegment(range(0), {})
    with core_pool() as pool:
        for segment in segments:
            known = [frame for frame in segment if frame in before.frames]
            rest = segment[len(known) :]

            def masks(camera: int, rest: range = rest) -> list[bytes]:
                still = backgrounds[camera]
                return [packed_mask(moving_pixels(picture(camera, frame), still)) for frame in rest]

            found = watched({one: pool.submit(masks, one) for one in cameras}, report, unwanted)
            kept = {camera: [before.packed(camera, frame) for frame in known] for camera in cameras}
            before = MaskSegment(segment, {camera: [*kept[camera], *found[camera]] for camera in cameras})
            yield before


def _shape(capture: Capture, camera: int) -> tuple[int, int]:
    return capture.cameras[camera].height, capture.cameras[camera].width
