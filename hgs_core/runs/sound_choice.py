"""How a run's sound is asked for, in words: what a file or a video holds is for `hgs_core.runs.sound`."""

from __future__ import annotations

__all__ = ["CAMERA_SOUND", "NO_SOUND", "OWN_SOUND", "camera_of_sound"]

OWN_SOUND = "auto"
"""The sound of the capture's first camera that has any."""

NO_SOUND = "none"

CAMERA_SOUND = "camera:"
"""With a camera's name behind it: the sound of its video."""


def camera_of_sound(audio: str) -> str | None:
    """Return the name of the camera whose sound `--audio` asks for, or None if it asks for something else."""
    return audio.removeprefix(CAMERA_SOUND) if audio.startswith(CAMERA_SOUND) else None
