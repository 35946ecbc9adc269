"""Pictures for the search of first points: those of one moment, and those of the room without movers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.capture.capture import Capture
from hgs_core.decompose.background import median_picture, sample_frames
from hgs_core.decompose.masks import MotionMasks
from hgs_core.points.same_moment import SameMoment
from hgs_core.scene.camera import Camera

__all__ = ["seen_at", "still_pictures"]

_STILL_FRAMES = 11  # frames in the median that is a camera's still picture
# Share of the sampled frames in which a pixel moves, from which on its background means nothing.
_UNKNOWN_BACKGROUND_SHARE = 0.5


def seen_at(
    capture: Capture, moment: SameMoment, masks: MotionMasks
) -> tuple[list[Camera], list[npt.NDArray[np.uint8]], list[npt.NDArray[np.bool_]]]:
    """Return the cameras of a moment, their pictures [H, W, 3] and motion masks [H, W]."""
    views = [capture.cameras[index] for index in moment.cameras]
    own = list(zip(moment.cameras, moment.frames, strict=True))
    return views, [capture.frame(*one) for one in own], [masks.mask(*one) for one in own]


def still_pictures(
    capture: Capture, masks: MotionMasks, cameras: Sequence[int]
) -> list[tuple[npt.NDArray[np.uint8], npt.NDArray[np.bool_]]]:
    """Return each camera's median picture [H, W, 3] over time and the pixels [H, W] where it is the background.

    Raises:
        InputError: a picture is missing or unreadable.
    """
    with core_pool() as pool:
        return list(pool.map(lambda index: _still_picture(capture, masks, index), cameras))


def _still_picture(
    capture: Capture, masks: MotionMasks, camera: int
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.bool_]]:
    """Return the median picture [H, W, 3] of a camera over time and the pixels [H, W] where it is the background."""
    sampled = sample_frames(len(capture.times), _STILL_FRAMES)
    picture = median_picture(np.stack([capture.frame(camera, frame) for frame in sampled]))
    moving = np.mean([masks.mask(camera, frame) for frame in sampled], axis=0)
    return picture, np.asarray(moving < _UNKNOWN_BACKGROUND_SHARE)
