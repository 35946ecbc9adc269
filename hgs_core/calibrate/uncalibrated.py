"""Folders of videos that nobody has given poses for."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.camera_formats import calibration
from hgs_core.capture.footage import FEWEST_VIDEOS, find_places, require_folder
from hgs_core.capture.sound.sound_only import is_sound_only

__all__ = ["are_enough_videos", "find_videos", "folder_below", "has_poses"]


def has_poses(folder: Path) -> bool:
    """Return whether a file of cameras lies in the folder that `open_capture` would read."""
    return next(calibration(folder), None) is not None


def find_videos(folder: Path) -> dict[str, Path]:
    """Return the videos of a folder, or of the nearest below that has two, by the names of their cameras.

    They come in the order of the numbers in these. A video is called as its camera, or is the only one in a folder that
    is; files of sound alone are none.

    Raises:
        InputError: the folder is missing, has no two videos, or two of one name.
    """
    require_folder(folder, "give a folder of videos, one of each camera")
    for place in find_places(folder):
        footage = [one for one in place.footage if not (one.video and is_sound_only(one.files[0]))]
        if place.kind == "videos" and len(footage) > 1:
            names = [one.name for one in footage]
            for name in names:
                if names.count(name) > 1:
                    raise InputError(place.folder, f"two videos are called {name}", "give each camera its own name")
            return {one.name: one.files[0] for one in footage}
    raise InputError(folder, "has no two videos", "put one video of each camera into it")


def folder_below(folder: Path, videos: Mapping[str, Path]) -> Path | None:
    """Return the one folder below `folder` that holds all the videos; None where they lie in it, or each in its own."""
    places = {video.parent for video in videos.values()}
    return places.pop() if len(places) == 1 and folder not in places else None


def are_enough_videos(folder: Path) -> bool:
    """Return whether poses can be looked for: the folder has three or more videos."""
    try:
        return len(find_videos(folder)) >= FEWEST_VIDEOS
    except InputError:
        return False  # opening the capture says why
