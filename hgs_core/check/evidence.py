"""The evidence of a check: features of several moments of every camera, and their matches, apart from poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import reduced_picture
from hgs_core.check.given_masks import MaskEvidence, mask_evidence
from hgs_core.points.features import Features, extract_features
from hgs_core.points.matching import LONGEST_SIDE, PairMatches, likely_pairs, match_moments, moving_pixels
from hgs_core.scene.camera import Camera

__all__ = ["CameraEvidence", "Evidence", "gather", "moments_of"]

_MOMENTS = 4
_FEW_FEATURES = 600  # features of a picture; with fewer it is searched at twice its size


@dataclass(frozen=True)
class CameraEvidence:
    """The evidence of one camera."""

    features: tuple[Features, ...]  # one entry a moment: all of the first, then moving ones
    moving: tuple[Features, ...]  # moving features, one entry a moment
    soon: dict[int, Features]  # if followed: a frame later, of the moments between the first and the last
    last: Features | None  # all of the last moment, where that is not the first
    level: tuple[int, float]  # the commonest grey level of the first picture, and the share of the pixels that have it
    masks: MaskEvidence | None = None  # None: without given masks


@dataclass(frozen=True)
class Evidence:
    """The evidence of all cameras."""

    cameras: tuple[Camera, ...]  # size of the searched pictures
    frames: tuple[int, ...]  # the moments
    views: tuple[CameraEvidence, ...]  # one per camera
    pairs: dict[tuple[int, int], PairMatches]


def moments_of(capture: Capture) -> tuple[int, ...]:
    """Return the frames that are looked at: spread over the capture, each with one behind it where there are two."""
    last = max(0, len(capture.times) - 2)
    return tuple(sorted({round(last * i / (_MOMENTS - 1)) for i in range(_MOMENTS)}))


def gather(capture: Capture, progress: ProgressCallback, *, followed: bool) -> Evidence:
    """Read the moments of every camera and match them, all likely pairs with each other.

    What moves is `followed` to the next frame where it has to tell by how many frames cameras are ahead.

    Raises:
        InputError: a picture or a mask is missing, unreadable or of a wrong size.
    """
    frames = moments_of(capture)
    cameras = tuple(camera.within(LONGEST_SIDE) for camera in capture.cameras)
    count = len(cameras)
    views = []
    with core_pool() as pool:
        looks = pool.map(lambda i: _look(capture, i, cameras[i], frames, followed), range(count))
        for done, view in enumerate(looks, count + 1):
            views.append(view)
            progress(Progress("check", done, 3 * count))
        wanted = likely_pairs([view.features for view in views])
        found: dict[tuple[int, int], PairMatches] = {}
        for done, (pair, matches) in enumerate(
            zip(
                wanted,
                pool.map(lambda p: match_moments(views[p[0]].features, views[p[1]].features), wanted),
                strict=True,
            ),
            1,
        ):
            if matches is not None:
                found[pair] = matches
            progress(Progress("check", 2 * count + count * done // len(wanted), 3 * count))
    return Evidence(cameras, frames, tuple(views), found)


def _look(capture: Capture, index: int, size: Camera, frames: Sequence[int], followed: bool) -> CameraEvidence:
    def picture(frame: int) -> npt.NDArray[np.uint8]:
        return reduced_picture(capture.frame(index, frame), size)

    pictures = [picture(frame) for frame in frames]
    first = extract_features(pictures[0])
    fine = len(first.xy) < _FEW_FEATURES
    if fine:
        first = extract_features(pictures[0], fine=True)
    level = _commonest_level(pictures[0])
    moves = moving_pixels(pictures) if len(frames) > 1 else []
    masks = mask_evidence(capture, index, frames, moves)
    if not moves:
        return CameraEvidence((first,), (), {}, None, level, masks)
    last = extract_features(pictures[-1], fine=fine)
    between = [extract_features(one, at, fine=fine) for one, at in zip(pictures[1:-1], moves[1:-1], strict=True)]
    moving = (_on(first, moves[0]), *between, _on(last, moves[-1]))
    soon = {
        moment: extract_features(picture(frames[moment] + 1), moves[moment], fine=fine)
        for moment in range(len(frames))[1:-1]
        if followed
    }
    return CameraEvidence((first, *moving[1:]), moving, soon, last, level, masks)


def _on(features: Features, mask: npt.NDArray[np.bool_]) -> Features:
    column, row = np.clip(features.xy.astype(int), 0, (mask.shape[1] - 1, mask.shape[0] - 1)).T
    kept = mask[row, column]
    return Features(features.xy[kept], features.descriptors[kept])


def _commonest_level(picture: npt.NDArray[np.uint8]) -> tuple[int, float]:
    counts = np.bincount(picture.mean(axis=2).round().astype(int).ravel())
    return int(counts.argmax()), float(counts.max() / counts.sum())
