"""The length of a video file by its header, without decoding."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from hgs_core.capture.files.container import open_container
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.pictures.video_packets import open_stream
from hgs_core.capture.pictures.video_stream import even_rate, stated_rate

__all__ = ["AnnouncedLength", "announced_length"]


class AnnouncedLength(NamedTuple):
    """The length of a video by its header; None where that states nothing."""

    frames: int | None
    rate: float | None  # frames per second
    even: bool  # the time between any two frames is the same; otherwise `rate` is a mean

    @property
    def seconds(self) -> float | None:
        """Duration; None without frames or rate."""
        return self.frames / self.rate if self.frames is not None and self.rate is not None else None


def announced_length(path: Path) -> AnnouncedLength:
    """Return the length that the header of a video states.

    Raises:
        InputError: the file is missing or no video.
    """
    import av

    try:
        with open_container(path) as container:
            stream, _ = open_stream(path, container)
            even = even_rate(stream)
            rate = even or stated_rate(container, stream)
            return AnnouncedLength(stream.frames or None, float(rate) or None, even is not None)
    except (av.FFmpegError, OSError) as error:
        raise unreadable(path, error, "copy or export it again", "the video is unreadable") from error
