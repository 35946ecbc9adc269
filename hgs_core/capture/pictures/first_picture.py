"""The first picture of a camera, found without the index of its video, for lists of captures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import open_container
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.footage import is_video
from hgs_core.capture.pictures.orientation import quarter_turns
from hgs_core.capture.pictures.picture_file import read_pixels
from hgs_core.capture.pictures.video_packets import open_stream

__all__ = ["first_picture"]


def first_picture(file: Path) -> npt.NDArray[np.uint8]:
    """Return the picture [H, W, 3] of a picture file, or the first one of a video, upright.

    Its colours are for a glance: those of a wide gamut or a high dynamic range are not converted.

    Raises:
        InputError: the file is missing, damaged or neither.
    """
    import av

    if not is_video(file.name):
        return read_pixels(file, upright=True)
    try:
        with open_container(file) as container:
            stream, _ = open_stream(file, container)
            frame = next(container.decode(stream), None)
            if frame is None:
                raise InputError(file, "the video has no picture", "export it again")
            return np.ascontiguousarray(np.rot90(frame.to_ndarray(format="rgb24"), quarter_turns(frame) or 0))
    except (av.FFmpegError, OSError) as error:
        raise unreadable(file, error, "copy or export it again", "the video is unreadable") from error
