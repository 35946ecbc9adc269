"""The choice of a run's sound, in words; `hgs_core.runs.sound` opens files and videos."""

from __future__ import annotations

__all__ = ["CAMERA_SOUND", "NO_SOUND", "OWN_SOUND", "camera_of_sound"]

OWN_SOUND = "auto"
"""The sound of the capture's first camera that has any."""

NO_SOUND = "none"

CAMERA_SOUND = "camera:"
"""With a camera's name behind it: the sound of its video."""


def camera_of_sound(audio: str) -> str | None:
    """Return the name of the camera in `--audio`, or None for any other choice."""
    return audio.removeprefix(CAMERA_SOUND) if audio.startswith(CAMERA_SOUND) else None
