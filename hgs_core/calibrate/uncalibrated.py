"""Folders of videos that nobody has given poses for."""

from __future__ import annotations

import re
from pathlib import Path

from hgs_core.base.errors import InputError

__all__ = ["find_videos", "has_poses"]

_VIDEOS = {".avi", ".m4v", ".mkv", ".mov", ".mp4", ".webm"}
_FOLDERS = (".", "videos")
_POSES = (
    "poses_bounds.npy", "poses_bounds_multipleview.npy", "train_meta.json", "transforms*.json", "models.json", "*.toml",
    "calibration/*.toml", "extri.yml", "cameras.txt", "cameras.bin", "sparse*/cameras.*", "sparse*/0/cameras.*",
    "colmap*/**/cameras.*",
)  # fmt: skip


def has_poses(folder: Path) -> bool:
    """Return whether a file lies in the folder that poses are usually kept in."""
    return any(next(folder.glob(pattern), None) is not None for pattern in _POSES)


def find_videos(folder: Path) -> list[Path]:
    """Return the videos of a folder, or of its folder videos/, by name; numbers in the order of their values.

    Raises:
        InputError: the folder is missing, has no two videos, or two of one name.
    """
    if not folder.is_dir():
        raise InputError(folder, "the folder does not exist", "give a folder of videos, one of each camera")
    for place in _FOLDERS:
        here = folder / place
        found = [file for file in here.glob("*") if file.suffix.lower() in _VIDEOS and file.is_file()]
        if len(found) > 1:
            stems = [file.stem for file in found]
            for stem in stems:
                if stems.count(stem) > 1:
                    raise InputError(here, f"two videos are called {stem}", "give each camera its own name")
            return sorted(found, key=_natural)
    raise InputError(folder, "has no two videos", "put one video of each camera into it")


def _natural(file: Path) -> list[tuple[int, int, str]]:
    parts = re.split(r"(\d+)", file.stem)
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in parts if part]
