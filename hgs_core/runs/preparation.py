"""The preparation of a capture: the starts of its videos, and the poses of its cameras."""

from __future__ import annotations

import dataclasses
import logging
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.base.writable import require_writable_folder
from hgs_core.calibrate.find_cameras import COLMAP_FOLDER, find_cameras
from hgs_core.calibrate.uncalibrated import find_videos, has_poses
from hgs_core.capture.load import clock_of_videos
from hgs_core.capture.open import open_capture
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.sound.sound_track import has_sound
from hgs_core.capture.time.sync import SYNC_FILE
from hgs_core.check.starts import Starts, starts_by_energy, starts_by_motion, starts_by_sound
from hgs_core.check.synchronise import FEWEST_FRAMES
from hgs_core.runs.run_folder import RunSpec

__all__ = ["prepared_capture"]

_MEMORY = 1 << 28  # bytes of decoded pictures; hardly any is looked at twice
_IN_STEP = 0.5  # frames: what cameras may be apart and still be called in step; motion tells no better
_SOUND_IN_STEP = 0.03  # seconds, ten metres of sound: less may be where the cameras stand, and not when they began

log = logging.getLogger(__name__)


def prepared_capture(spec: RunSpec, own: Path, progress: ProgressCallback) -> Path | None:
    """Write sync.json and sparse/0 where the capture lacks them and its videos tell them.

    They are written into the capture's folder, or into the folder `own` of the run where that cannot be done or `own`
    is there already, as it is where others see another copy of the capture.

    Returns:
        `own` if something lies there, else None.

    Raises:
        InputError: poses cannot be found, or a way to synchronise that was asked for does not tell enough.
    """
    found = own if _holds_any(own) else None
    by = spec.config.capture.sync
    posed = has_poses(spec.capture) or (found is not None and has_poses(found))
    if by != "none":
        starts = _of_posed(spec, found, by, progress) if posed else _of_unposed(spec.capture, found, by, progress)
        if starts is not None:
            place = _place_of_findings(spec.capture, own)
            place.mkdir(parents=True, exist_ok=True)
            starts.write(place / SYNC_FILE)
            apart = f"{starts.apart:.3g} {starts.unit}"
            log.warning(
                "%s: by %s, the cameras began up to %s apart; written to %s",
                spec.capture,
                {"sound": "their sound", "motion": "what moves"}[starts.by],
                apart,
                place / SYNC_FILE,
            )
    if not posed:
        place = _place_of_findings(spec.capture, own)
        find_cameras(spec.capture, found=own if place == own else None, progress=_as_cameras(progress))
        log.warning(
            "%s: poses were found from the videos and written to %s (docs/cameras.md)",
            spec.capture,
            place / COLMAP_FOLDER,
        )
    return own if _holds_any(own) else None


def _place_of_findings(capture: Path, own: Path) -> Path:
    if own.is_dir():
        return own
    try:
        require_writable_folder(capture)
    except InputError:
        log.warning("%s cannot be written to: what is found is kept in %s", capture, own)
        return own
    return capture


def _holds_any(folder: Path) -> bool:
    return folder.is_dir() and any(folder.iterdir())


def _of_posed(spec: RunSpec, found: Path | None, by: str, progress: ProgressCallback) -> Starts | None:
    capture = open_capture(spec.capture, found=found, cache_bytes=_MEMORY)
    if not capture.unaligned:
        return None
    names, frames = [camera.name for camera in capture.cameras], len(capture.times)
    if by in ("auto", "audio"):
        starts = _by_sound(spec.capture, names, list(capture.unaligned), by, progress)
        if starts is not None or by == "audio":
            return starts
    if by == "motion":
        return starts_by_motion(capture, progress)
    rough = starts_by_energy(names, capture.frame, frames, progress)
    if rough is None:
        _say_unsure(spec.capture, frames)
        return None
    if rough.apart <= 2 * _IN_STEP:
        return None
    try:
        return starts_by_motion(capture, progress)
    except InputError as error:
        log.warning("%s: %s; the cameras are in step to about half a frame", spec.capture, error.problem)
        return rough


def _of_unposed(folder: Path, found: Path | None, by: str, progress: ProgressCallback) -> Starts | None:
    files = find_videos(folder)
    names, videos = list(files), [VideoReader(file) for file in files.values()]
    clock, told = clock_of_videos(folder, names, videos, found)
    if told:
        return None
    if by in ("auto", "audio"):
        starts = _by_sound(folder, names, list(files.values()), by, progress)
        if starts is not None or by == "audio":
            return starts

    def picture(camera: int, frame: int) -> npt.NDArray[np.uint8]:
        return videos[camera].read(int(clock.frames[camera, frame]), 0)[0]

    rough = starts_by_energy(names, picture, len(clock.times), progress)
    if rough is None and by == "motion":
        problem = "what moves does not tell when the cameras began, without poses"
        raise InputError(
            folder, problem, f"write the offsets to {SYNC_FILE} by hand (docs/captures.md), or --sync none"
        )
    if rough is None:
        _say_unsure(folder, len(clock.times))
        return None
    return rough if by == "motion" or rough.apart > 2 * _IN_STEP else None


def _say_unsure(where: Path, frames: int) -> None:
    """Say that nothing tells whether videos are in step; not of a few frames, of which nothing could."""
    if frames >= FEWEST_FRAMES:
        log.warning(
            "%s: nothing tells whether the videos are in step, and they are taken to be; hgs sync looks closer", where
        )


def _by_sound(where: Path, names: list[str], videos: list[Path], by: str, progress: ProgressCallback) -> Starts | None:
    """Return the starts from sound; if sound was not requested, None unless it clearly shows different starts."""
    if by == "auto" and not any(has_sound(video) for video in videos):
        return None
    try:
        starts = starts_by_sound(where, names, videos, progress)
        return starts if by == "audio" or starts.apart > _SOUND_IN_STEP else None
    except InputError as error:
        if by == "audio":
            raise
        log.warning("%s: %s; what moves is asked", where, error.problem)
        return None


def _as_cameras(progress: ProgressCallback) -> ProgressCallback:
    """Report the parts of the search for cameras as one stage, which rises to its end."""
    parts = {"features": 0, "matches": 1, "mapping": 2}
    done = 0

    def report(update: Progress) -> None:
        nonlocal done  # mapping begins anew with other lenses, where the first do not fit
        done = max(done, 100 * parts[update.stage] + 100 * update.done // max(1, update.total))
        progress(dataclasses.replace(update, stage="cameras", done=done, total=100 * len(parts)))

    return report
