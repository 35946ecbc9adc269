"""When each camera began, to parts of a frame: by motion energy, and by moving features under known poses."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import reduced_picture
from hgs_core.check.dead_cameras import require_alive
from hgs_core.check.epipolar import Rig
from hgs_core.check.evidence import CameraEvidence
from hgs_core.check.starts_by_features import feature_offsets, match_leads
from hgs_core.check.starts_by_motion import energy_offsets
from hgs_core.check.watched_cameras import watch_cameras
from hgs_core.points.features import extract_features
from hgs_core.points.matching import LONGEST_SIDE, moving_pixels
from hgs_core.points.sfm import camera_pairs
from hgs_core.scene.camera import Camera

__all__ = ["FARTHEST", "FEWEST_FRAMES", "LEAST_AGREEMENT", "find_offsets"]

FEWEST_FRAMES = 30
"""Of fewer frames, offsets of several frames were told wrong."""

FARTHEST = 15
"""Frames that two cameras may be apart."""

LEAST_AGREEMENT = 0.9
"""The least share of a camera's motion energy in agreement; below it, features decide."""

_FRAMES = 300  # first frames with motion energy
_MOMENTS = 6
_ROUNDS = 4
_SETTLED = 0.2  # frames by which offsets may change still
_LEAST_SHARE = 0.25  # share of a camera's matches in agreement; later rounds confirm it
_NEAR = 0.75  # frames: features correct what motion energy says by less; by more they are chance


def find_offsets(capture: Capture, progress: ProgressCallback) -> list[float | None]:
    """Return by how many frames each camera is ahead of most of them; None for one of which too little tells.

    A camera that is ahead by 2.5 shows in its frame k what most show between their frames k + 2 and k + 3.

    Raises:
        InputError: a picture is missing or unreadable, or a camera is mostly frozen or blank.
    """
    names, frames = [camera.name for camera in capture.cameras], len(capture.times)
    count = len(names)
    watched = watch_cameras([partial(capture.frame, index) for index in range(count)], np.arange(min(frames, _FRAMES)))
    require_alive(capture.path, names, watched)
    if frames < FEWEST_FRAMES or count < 2:
        return [None] * count
    energies = [camera.energy() for camera in watched]
    with core_pool() as pool:
        energy = energy_offsets(energies, FARTHEST, LEAST_AGREEMENT)
        progress(Progress("sync", 1, 1 + _ROUNDS))
        start = [offset or 0.0 for offset in energy_offsets(energies, FARTHEST)]  # near enough to begin with
        features: list[float | None] = [None] * count
        for done in range(_ROUNDS):
            features, before = _by_features(capture, start, pool), start
            progress(Progress("sync", 2 + done, 1 + _ROUNDS))
            start = [old if new is None else new for old, new in zip(start, features, strict=True)]
            if max(abs(new - old) for new, old in zip(start, before, strict=True)) < _SETTLED:
                break
    return _agreed(energy, features)


def _agreed(energy: Sequence[float | None], features: Sequence[float | None]) -> list[float | None]:
    """Return the offsets of both ways: features', where they contradict energy's in few cameras or know more."""
    both = [(a, b) for a, b in zip(energy, features, strict=True) if a is not None and b is not None]
    alike = sum(abs(a - b) < _NEAR for a, b in both)
    if both and 2 * alike >= len(both):  # energy is right to a frame: features that say something else are chance
        pairs = zip(energy, features, strict=True)
        return [b if a is None or (b is not None and abs(a - b) < _NEAR) else a for a, b in pairs]
    known = len(features) - features.count(None)
    return list(features) if 2 * known >= len(features) else list(energy)


def _by_features(capture: Capture, start: Sequence[float], pool: ThreadPoolExecutor) -> list[float | None]:
    """Return the offsets that moving features tell, looked for near those of `start`."""
    count, frames = len(capture.cameras), len(capture.times)
    sizes = [camera.within(LONGEST_SIDE) for camera in capture.cameras]
    reach = int(np.ceil(max(abs(offset) for offset in start))) + 1
    moments = np.linspace(reach, max(reach, frames - 2 - reach), _MOMENTS).round()
    used = [[int(np.clip(round(moment - offset), 0, frames - 2)) for moment in moments] for offset in start]
    views = list(pool.map(lambda i: _moving_view(capture, i, sizes[i], used[i]), range(count)))
    leads = match_leads(Rig.of(sizes), camera_pairs(sizes), views)
    # Frames were chosen whole: what is left of each offset is what the chosen ones are ahead by.
    whole = np.array([float(np.median(moments - np.array(own))) for own in used])
    left = feature_offsets(count, leads, _LEAST_SHARE)
    offsets = [None if one is None else one + float(rest) for one, rest in zip(left, whole, strict=True)]
    known = [offset for offset in offsets if offset is not None]
    middle = float(np.median(known)) if known else 0.0
    return [None if offset is None else offset - middle for offset in offsets]


def _moving_view(capture: Capture, index: int, size: Camera, frames: Sequence[int]) -> CameraEvidence:
    def picture(frame: int) -> npt.NDArray[np.uint8]:
        return reduced_picture(capture.frame(index, frame), size)

    pictures = [picture(frame) for frame in frames]
    moves = moving_pixels(pictures)
    moving = tuple(extract_features(one, at, fine=True) for one, at in zip(pictures, moves, strict=True))
    soon = {
        number: extract_features(picture(frame + 1), moves[number], fine=True) for number, frame in enumerate(frames)
    }
    return CameraEvidence(moving, moving, soon, None, (0, 0.0))
