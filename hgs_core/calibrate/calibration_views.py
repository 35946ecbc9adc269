"""The views for finding poses: features of several moments of each camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.pictures.picture import reduced_picture
from hgs_core.points.features import Features, extract_features
from hgs_core.points.matching import LONGEST_SIDE, moving_pixels
from hgs_core.scene.camera import Camera

__all__ = ["MOMENTS", "Pinhole", "View", "look"]

MOMENTS = 10
_ENOUGH_FEATURES = 2500  # features of a picture with which four moments suffice
_FEWER_MOMENTS = 4

ReadPicture = Callable[[int, int], npt.NDArray[np.uint8]]
"""Return the picture [H, W, 3] of a camera and a frame, by their numbers."""


@dataclass(frozen=True)
class Pinhole:
    """Intrinsics that are known, in pixels."""

    fx: float
    fy: float
    cx: float
    cy: float


@dataclass(frozen=True)
class View:
    """One camera as it is seen."""

    name: str
    width: int  # pixels of its pictures
    height: int
    known: Pinhole | None  # pixels of these pictures
    features: tuple[Features, ...]  # pixels of these pictures, one entry a moment: all of the first, then moving ones


def look(
    names: Sequence[str], known: Sequence[Pinhole | None], read: ReadPicture, frames: int, progress: ProgressCallback
) -> list[View]:
    """Return the views of synchronous cameras with `frames` frames each, from ten moments, or four where these do.

    Moments are spread over the frames, and are the same for all cameras.
    """
    views = []
    details = [len(extract_features(_small(read(camera, 0))[0], fine=True).xy) for camera in (0, len(names) // 2)]
    count = _FEWER_MOMENTS if min(details) >= _ENOUGH_FEATURES else MOMENTS
    moments = sorted({round((frames - 1) * moment / (count - 1)) for moment in range(count)})

    def one(camera: int) -> View:
        return _view(names[camera], known[camera], [read(camera, frame) for frame in moments])

    with core_pool() as pool:
        for done, view in enumerate(pool.map(one, range(len(names))), 1):
            views.append(view)
            progress(Progress("features", done, len(names)))
    return views


def _view(name: str, known: Pinhole | None, pictures: list[npt.NDArray[np.uint8]]) -> View:
    height, width = pictures[0].shape[:2]
    small = [_small(picture)[0] for picture in pictures]
    found = [extract_features(small[0], fine=True)]
    if len(small) > 1:
        moves = moving_pixels(small)
        found += [extract_features(one, at, fine=True) for one, at in zip(small[1:], moves[1:], strict=True)]
    scale = _small(pictures[0])[1]
    return View(name, width, height, known, tuple(Features(one.xy * scale, one.descriptors) for one in found))


def _small(picture: npt.NDArray[np.uint8]) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float64]]:
    """Return the picture reduced by a whole factor, and how many of its pixels (x, y) one of the new ones is."""
    height, width = picture.shape[:2]
    whole = Camera("", width, height, width, width, width / 2, height / 2, np.eye(4))
    size = whole.within(LONGEST_SIDE)
    return reduced_picture(picture, size), np.array([width / size.width, height / size.height])
