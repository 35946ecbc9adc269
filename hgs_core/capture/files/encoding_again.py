"""The command that puts a better video in a file's place, for messages: tried with FFmpeg 5.1."""

from __future__ import annotations

import shlex
from pathlib import Path

__all__ = ["encode_again"]


def encode_again(path: Path, *, reading: str = "", writing: str = "-c:v libx264 -crf 12") -> str:
    """Return the command, with options of FFmpeg for reading and for writing; it runs in the file's folder."""
    old, new = shlex.quote(path.name), shlex.quote(f"{path.stem}.mp4")
    encoded = f"ffmpeg {reading + ' ' if reading else ''}-i {old} {writing} new.mp4"
    if path.suffix.lower() == ".mp4":
        return f"{encoded} && mv new.mp4 {old}"
    return f"{encoded} && mv new.mp4 {new} && rm {old}"
