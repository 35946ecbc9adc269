"""The beginning of a run: its capture and config are checked, and missing starts and cameras are found.

This module is light, as `hgs_core.runs.stages` is: the API process creates runs without loading torch.
"""

from __future__ import annotations

import dataclasses
import logging
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, interruptible
from hgs_core.base.wording import counted
from hgs_core.calibrate.uncalibrated import are_enough_videos, find_videos, folder_below, has_poses
from hgs_core.capture.capture import Capture
from hgs_core.capture.held_out import AUTO, with_held_out
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.pictures.video_index import indexed_packets
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.require_room import require_room_for
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.run_folder import RunFolder, RunSpec

__all__ = ["create_run", "prepare"]

_MIN_CAMERAS = 2

log = logging.getLogger(__name__)


def create_run(run: Path, capture: Path, config: RunConfig, given: GivenFiles | None = None) -> RunConfig:
    """Check the capture and the config and write `run`/run.json; an equal run that is there already is kept.

    What was left out or found is logged. Returns the config of the run, which names the camera that is held out where
    `config` leaves the choice; that of videos without poses is chosen when `prepare` has found them.

    Raises:
        InputError: the capture is unusable, a held-out camera is unknown, the file has no sound, or the folder is
            taken. Nothing is written.
    """
    from hgs_core.runs.sound import require_sound_file, require_sounding_video

    given = given or GivenFiles()
    audio = require_sound_file(given.audio)
    spec = RunSpec(capture.resolve(), "", config, given.resolved(), prepared=False).with_audio(audio)
    folder = RunFolder(run)
    found = folder.found if folder.found.is_dir() else None
    if not has_poses(capture) and (found is None or not has_poses(found)) and are_enough_videos(capture):
        videos = find_videos(capture)
        if (place := folder_below(capture, videos)) is not None:
            log.warning("%s: has no videos of its own; those of %s are taken", capture, place)
        for video in videos.values():
            VideoReader(video)  # one that is none is refused now, and not when poses are looked for
        require_sounding_video(audio, videos)
        folder.write_spec(spec)
        return config
    opened = RunSpec(capture, "", config, given, found=found).open_unchecked()  # errors name paths as they were given
    sources = [opened.video(camera) for camera in range(len(opened.cameras))]
    require_sounding_video(
        audio, {one.name: video and video[0] for one, video in zip(opened.cameras, sources, strict=True)}
    )
    config = _with_held_out(config, folder, opened)
    _require_enough(config, opened)
    prepared = not opened.unaligned or config.capture.sync == "none"
    folder.write_spec(
        dataclasses.replace(spec, fingerprint=opened.fingerprint(), config=config, found=found, prepared=prepared)
    )
    for source in sources:
        if source is not None:
            indexed_packets(source[0], folder.videos)  # packets in memory, written for other processes
    for note in opened.notes:
        log.warning("%s: %s", capture, note)
    return config


def _require_enough(config: RunConfig, capture: Capture) -> None:
    left = len(config.capture.training_cameras(capture))
    if left < _MIN_CAMERAS:
        raise InputError.of_field(
            "config.capture.hold_out",
            f"leaves {left} of {counted(len(capture.cameras), 'camera')} to train on",
            f"keep at least {_MIN_CAMERAS}",
        )


def _with_held_out(config: RunConfig, folder: RunFolder, capture: Capture) -> RunConfig:
    """Choose the camera to hold out, where that is asked for; a run that is there keeps its own."""
    if config.capture.hold_out != AUTO:
        return config
    if folder.spec.exists() and (there := folder.read_spec().config.capture.hold_out) != AUTO:
        return config.changed({"capture.hold_out": there})
    chosen = with_held_out(config.capture, capture.cameras)
    for name in chosen.hold_out:
        log.warning(
            "camera %s is held out, so that hgs eval can score the scene with it; --hold-out names others", name
        )
    return dataclasses.replace(config, capture=chosen)


@interruptible()
def prepare(run: Path, progress: ProgressCallback) -> None:
    """Find out when the videos began and where the cameras stand, where the capture does not say.

    Both are written beside the videos, sync.json and sparse/0, or below the run's folder where that cannot be done.

    Raises:
        InputError: the videos tell too little.
    """
    folder = RunFolder(run)
    spec = folder.read_spec()
    if spec.prepared:
        return
    from hgs_core.runs.preparation import prepared_capture

    found = prepared_capture(spec, folder.found, progress)
    spec = dataclasses.replace(spec, found=found, prepared=True)
    opened = spec.open_unchecked()
    config = _with_held_out(spec.config, folder, opened)
    _require_enough(config, opened)
    if not spec.fingerprint:
        for note in opened.notes:
            log.warning("%s: %s", spec.capture, note)
    folder.replace_spec(dataclasses.replace(spec, fingerprint=opened.fingerprint(), config=config))
    if not spec.fingerprint:  # otherwise it was looked at before anything was done
        log.info("%s %s", spec.capture, require_room_for(folder, opened, config).sentence())
