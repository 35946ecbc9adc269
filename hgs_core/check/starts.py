"""The starts of cameras, found by sound or motion, and their file: sync.json."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.atomic import write_bytes
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.capture.sound.sound_track import read_sound
from hgs_core.capture.time.sync import SYNC_FILE
from hgs_core.check.starts_by_motion import energy_offsets
from hgs_core.check.starts_by_sound import sound_starts
from hgs_core.check.synchronise import FARTHEST, FEWEST_FRAMES, LEAST_AGREEMENT, find_offsets
from hgs_core.check.watched_cameras import watch_cameras

__all__ = ["Starts", "starts_by_energy", "starts_by_motion", "starts_by_sound"]

_FRAMES = 90  # first frames with motion energy, before poses are known
_CURE = f"write the offsets to {SYNC_FILE} by hand (docs/captures.md)"


@dataclass(frozen=True)
class Starts:
    """When the first frame of each camera was taken."""

    by: str  # sound or motion
    unit: str  # seconds or frames
    values: dict[str, float]  # camera -> seconds after a camera that began early
    confidence: dict[str, float] = field(default_factory=dict)  # 0..1 by camera, where it is known

    @property
    def apart(self) -> float:
        """How far the first and the last are apart, in the unit."""
        return max(self.values.values()) - min(self.values.values())

    def lines(self) -> list[str]:
        """Return a line for each camera, for people."""
        width = max(len(name) for name in self.values)
        return (
            [
                f"{name:<{width}} {value:+.4f} s" if self.unit == "seconds" else f"{name:<{width}} {value:+.2f} frames"
                for name, value in self.values.items()
            ]
            if not self.confidence
            else [
                f"{name:<{width}} {value:+.4f} s  confidence {self.confidence[name]:.2f}"
                for name, value in self.values.items()
            ]
        )

    def write(self, file: Path) -> None:
        """Write sync.json."""
        content: dict[str, Any] = {self.unit: self.values, "by": self.by}
        if self.confidence:
            content["confidence"] = self.confidence
        write_bytes(file, json.dumps(content, indent=1).encode() + b"\n")


def starts_by_sound(where: Path, names: Sequence[str], videos: Sequence[Path], progress: ProgressCallback) -> Starts:
    """Return when cameras began by the sound of their videos.

    Raises:
        InputError: a camera has no sound, heard nothing that the others did, or contradicts them.
    """
    progress(Progress("sync", 0, len(videos) + 1))
    tracks = []
    for done, video in enumerate(videos, 1):
        tracks.append(read_sound(video))
        progress(Progress("sync", done, len(videos) + 1))
    without = [name for name, track in zip(names, tracks, strict=True) if track is None]
    if without:
        problem = f"there is no sound track in the video of {', '.join(without)}"
        raise InputError(where, problem, f"go by what moves (motion), or {_CURE}")
    told = sound_starts(tracks)
    progress(Progress("sync", len(videos) + 1, len(videos) + 1))
    deaf = [name for name, heard in zip(names, told.cameras, strict=True) if heard is None]
    if deaf:
        problem = f"the sound of {', '.join(deaf)} has nothing that fits the others' at one place alone"
        raise InputError(where, problem, f"clap once where all cameras hear it, go by what moves (motion), or {_CURE}")
    if told.disagreeing:
        listed = ", ".join(names[camera] for camera in told.disagreeing)
        problem = f"the sound of {listed} fits other cameras' at times that contradict each other"
        raise InputError(where, problem, f"is it an echo, or sound by cable? Go by what moves (motion), or {_CURE}")
    heard = {name: one for name, one in zip(names, told.cameras, strict=True) if one is not None}
    return Starts(
        "sound",
        "seconds",
        {name: round(one.seconds, 5) for name, one in heard.items()},
        {name: round(one.confidence, 2) for name, one in heard.items()},
    )


def starts_by_motion(capture: Capture, progress: ProgressCallback) -> Starts:
    """Return the starts of cameras from motion, under known poses.

    Raises:
        InputError: too little that moves is seen by some camera, or it is mostly frozen or blank; names it. There are
            too few frames, or the poses are reflections.
    """
    if capture.mirrored:
        raise InputError(capture.path, "its poses are reflections", "have them corrected: hgs check --fix-poses")
    offsets = find_offsets(capture, progress)
    names = [camera.name for camera in capture.cameras]
    untold = [name for name, offset in zip(names, offsets, strict=True) if offset is None]
    if untold and len(capture.times) < FEWEST_FRAMES:
        problem = f"{len(capture.times)} frames are too few to measure when the cameras began"
        raise InputError(capture.path, problem, f"{FEWEST_FRAMES} or more tell it; with fewer, {_CURE}")
    if untold:
        raise InputError(capture.path, f"too little that moves is seen by {', '.join(untold)}", _CURE)
    return Starts(
        "motion",
        "frames",
        {name: round(offset, 2) + 0.0 for name, offset in zip(names, offsets, strict=True) if offset is not None},
    )


def starts_by_energy(
    names: Sequence[str],
    picture: Callable[[int, int], npt.NDArray[np.uint8]],  # camera, frame -> picture
    frames: int,
    progress: ProgressCallback,
) -> Starts | None:
    """Return when cameras began by how much changes from frame to frame, which needs no poses; None if that is unclear.

    Right to about half a frame: `starts_by_motion` tells more. Nothing is clear of a camera that was mostly dead.
    """
    frames, count = min(frames, _FRAMES), len(names)
    if frames < FEWEST_FRAMES:
        return None
    pictures = [partial(picture, camera) for camera in range(count)]
    watched = watch_cameras(pictures, np.arange(frames), lambda done: progress(Progress("sync", done, count)))
    offsets = energy_offsets([camera.energy() for camera in watched], FARTHEST, LEAST_AGREEMENT)
    told = {name: round(o, 2) + 0.0 for name, o in zip(names, offsets, strict=True) if o is not None}
    return Starts("motion", "frames", told) if len(told) == count else None
