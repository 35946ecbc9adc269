"""Files called like videos that hold sound alone: a microphone's recording beside the cameras'."""

from __future__ import annotations

from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import open_container

__all__ = ["is_sound_only"]


def is_sound_only(file: Path) -> bool:
    """Whether a file can be opened, and has sound and no pictures."""
    import av

    try:
        with open_container(file) as container:
            return bool(container.streams.audio) and not container.streams.video
    except (av.FFmpegError, OSError, InputError):
        return False  # whoever reads it as a video says why it is none
