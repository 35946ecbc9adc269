"""The sound of a video, on the clock of its frames."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import open_container
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.pictures.video_stream import video_stream

if TYPE_CHECKING:
    from av.container import InputContainer

__all__ = ["SOUND_RATE", "has_sound", "read_sound", "sound_begin"]

SOUND_RATE = 16_000
"""Samples per second: claps and voices lie below 8 kHz."""

_LONGEST = 120.0  # seconds that are read: clocks of two phones drift by a few milliseconds over more


def has_sound(path: Path) -> bool:
    """Return whether a video has a sound track, as far as it can be read."""
    import av

    try:
        with open_container(path) as container:
            return bool(container.streams.audio)
    except (av.FFmpegError, OSError, InputError):
        return False


def sound_begin(path: Path) -> float:
    """Return when, by the times of a file with sound, sample 0 of `read_sound` is, seconds.

    Raises:
        InputError: the file is missing or its sound is damaged.
    """
    import av

    try:
        with open_container(path) as container:
            begin = _begin(path, container)
            if begin is None:
                begin = float(next(container.decode(container.streams.audio[0])).time or 0.0)
            return begin
    except (av.FFmpegError, OSError, StopIteration) as error:
        raise unreadable(path, error, "export it again", "the sound is unreadable") from error


def read_sound(path: Path) -> npt.NDArray[np.float32] | None:
    """Return the first two minutes of a video's sound [N], its channels' mean; None if it has no sound track.

    Sample 0 belongs to the moment of the video's first frame: sound from before it is cut off, and silence stands for
    what is missing. In a file without pictures it is the first that sounds.

    Raises:
        InputError: the file is missing or its sound is damaged.
    """
    import av

    try:
        with open_container(path) as container:
            if not container.streams.audio:
                return None
            stream, begin = container.streams.audio[0], _begin(path, container)
            resampler = av.AudioResampler(format="flt", layout="mono", rate=SOUND_RATE)
            parts: list[npt.NDArray[np.float32]] = []
            first: float | None = None
            samples = 0
            for frame in container.decode(stream):
                if first is None:
                    first = float(frame.time or 0.0)
                for part in resampler.resample(frame):
                    parts.append(np.asarray(part.to_ndarray(), np.float32).reshape(-1))
                    samples += len(parts[-1])
                if samples > (_LONGEST + max(0.0, (begin or first) - first)) * SOUND_RATE:
                    break
    except (av.FFmpegError, OSError) as error:
        raise unreadable(path, error, "export it again, or use --sync motion", "the sound is unreadable") from error
    if first is None or samples == 0:
        return None
    begin = first if begin is None else begin
    sound = np.concatenate(parts)
    lead = round((first - begin) * SOUND_RATE)
    sound = np.pad(sound, (lead, 0)) if lead > 0 else sound[-lead:]
    return np.asarray(sound[: round(_LONGEST * SOUND_RATE)], np.float32)


def _begin(path: Path, container: InputContainer) -> float | None:
    """Return the time of a file's first picture, seconds; None without pictures."""
    video, _ = video_stream(path, container)
    return None if video is None else float((video.start_time or 0) * (video.time_base or 0))
