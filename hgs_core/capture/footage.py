"""Where pictures lie: videos, folders of pictures, folders of moments, or photographs, anywhere below a capture.

| kind        | files                                          | one camera's pictures            |
|-------------|------------------------------------------------|----------------------------------|
| videos      | FOLDER/<camera>.mp4, or <camera>/any name.mp4  | a video, the only one there      |
| folders     | FOLDER/<camera>/<frame>.png, or .../images/... | the pictures of its folder       |
| moments     | FOLDER/<frame>/<camera>.png, or .../images/... | one picture of every folder      |
| photographs | FOLDER/<camera>.png                            | one picture                      |

Frames come in the order of the numbers in their names.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.picture import list_folder, list_folders

__all__ = [
    "FEWEST_VIDEOS",
    "Footage",
    "Kind",
    "Place",
    "find_places",
    "is_picture",
    "is_video",
    "natural_order",
    "require_folder",
]

Kind = Literal["videos", "folders", "moments", "photographs"]

FEWEST_VIDEOS = 3
"""Poses can be found of so many videos or more: two tell no focal length."""

_PICTURES = frozenset(("png", "jpg", "jpeg", "jpe", "jp2", "tif", "tiff", "bmp", "webp", "ppm", "pgm", "pnm", "tga"))
_FOREIGN = frozenset(("heic", "heif", "avif", "gif"))  # pictures that are not read, and are refused with the way out
_VIDEOS = frozenset(
    (
        "mp4",
        "m4v",
        "mov",
        "qt",
        "mkv",
        "webm",
        "avi",
        "mts",
        "m2ts",
        "m2t",
        "ts",
        "mpg",
        "mpeg",
        "mpe",
        "m2v",
        "mpv",
        "vob",
        "wmv",
        "asf",
        "flv",
        "f4v",
        "3gp",
        "3g2",
        "mxf",
        "gxf",
        "lxf",
        "ogv",
        "ogm",
        "rm",
        "rmvb",
        "dv",
        "y4m",
        "h264",
        "264",
        "avc",
        "h265",
        "265",
        "hevc",
        "ivf",
        "obu",
        "av1",
        "nut",
        "insv",
        "360",
        "mj2",
        "mjpg",
        "mjpeg",
    )
)
# Folders that hold other things: masks, calibration, what structure from motion leaves behind.
_SKIPPED = re.compile(
    r"\..*|masks?|seg|sparse.*|stereo|dense|calib.*|intrinsics?|extrinsics?|depths?|normals?|flow|openpose|"
    r"annots?|output|models?|__pycache__",
    re.IGNORECASE,
)
_INNER = ("images", "image", "frames", "rgb", "color", "input")  # folders between a camera's folder and its pictures
_DEEPEST = 3  # folders below the capture
_DIGITS = re.compile(r"(\d+)")


@dataclass(frozen=True)
class Footage:
    """The pictures that are called alike: those of one camera."""

    name: str
    files: tuple[Path, ...]  # one video, or pictures in the order of their frames
    video: bool = False


@dataclass(frozen=True)
class Place:
    """A folder with footage of one kind."""

    folder: Path
    kind: Kind
    footage: tuple[Footage, ...]  # sorted by name


def is_video(name: str) -> bool:
    """Whether a file is called like a video."""
    return _ending(name) in _VIDEOS


def is_picture(name: str) -> bool:
    """Whether a file is called like a picture."""
    return _ending(name) in _PICTURES


def natural_order(name: str) -> tuple[tuple[int, int, str], ...]:
    """Return the sort key of natural order: cam2 before cam10."""
    parts = (part for part in _DIGITS.split(name.casefold()) if part)
    return (*((0, int(part), "") if part.isdigit() else (1, 0, part) for part in parts), (-1, 0, name))


def require_folder(path: Path, cure: str) -> None:
    """Refuse a capture's path that leads to no folder.

    Raises:
        InputError: it is a file, or nothing is there.
    """
    if not path.is_dir():
        raise InputError(path, "is a file, not a folder" if path.exists() else "the folder does not exist", cure)


def find_places(capture: Path) -> list[Place]:
    """Return every folder with footage, the nearest to the capture's own first.

    Raises:
        InputError: a folder may not be read.
    """
    return [place for folder, depth in _folders(capture) for place in _places(folder, depth)]


def _folders(capture: Path) -> Iterator[tuple[Path, int]]:
    """Yield folders, and how many below each are looked at."""
    level = [capture]
    for depth in range(_DEEPEST, -1, -1):
        yield from ((folder, depth) for folder in level)
        level = [folder / name for folder in level for name in list_folders(folder) if not _SKIPPED.fullmatch(name)]


def _places(folder: Path, depth: int) -> Iterator[Place]:
    names = sorted(list_folder(folder), key=natural_order)
    if videos := [name for name in names if is_video(name)]:
        yield Place(folder, "videos", tuple(Footage(Path(name).stem, (folder / name,), True) for name in videos))
    below = {name: _pictures(folder / name) for name in list_folders(folder) if not _SKIPPED.fullmatch(name)}
    if one_each := _one_video_each(folder, depth, sorted(below, key=natural_order), videos):
        yield Place(folder, "videos", one_each)
    leaves = {name: below[name] for name in sorted(below, key=natural_order) if below[name]}
    if leaves:
        yield Place(folder, "folders", tuple(Footage(name, files) for name, files in leaves.items()))
    if len(leaves) > 1 and all(_DIGITS.search(name) for name in leaves):
        yield from _moments(folder, leaves)
    if photographs := [name for name in names if is_picture(name)]:
        yield Place(folder, "photographs", tuple(Footage(Path(name).stem, (folder / name,)) for name in photographs))
    if leaves:
        nested = (
            Footage(file.relative_to(folder).with_suffix("").as_posix(), (file,))
            for files in leaves.values()
            for file in files
        )
        yield Place(folder, "photographs", tuple(nested))


def _one_video_each(folder: Path, depth: int, names: Sequence[str], beside: Sequence[str]) -> tuple[Footage, ...]:
    """Return the videos of the folders that hold one, perhaps farther below, called as these, and those beside them.

    None if there are no such folders. A video beside a folder of its name counts for it.
    """
    found = {Path(name).stem: folder / name for name in beside}
    folders = {name: videos[0] for name in names if len(videos := _videos_below(folder / name, depth)) == 1}
    if not folders or len(folders | found) < 2:
        return ()
    both = folders | found
    return tuple(Footage(name, (both[name],), True) for name in sorted(both, key=natural_order))


def _videos_below(folder: Path, depth: int) -> list[Path]:
    own = [folder / name for name in list_folder(folder) if is_video(name)] if depth > 0 else []
    if own or depth < 1:
        return own
    below = (name for name in list_folders(folder) if not _SKIPPED.fullmatch(name))
    return [file for name in below for file in _videos_below(folder / name, depth - 1)]


def _moments(folder: Path, leaves: dict[str, tuple[Path, ...]]) -> Iterator[Place]:
    """Yield the pictures that are called alike in most folders; where one lacks a picture, its camera saw nothing."""
    found: dict[str, list[Path]] = {}
    for files in leaves.values():
        for file in files:
            found.setdefault(file.stem, []).append(file)
    names = sorted((name for name, files in found.items() if 2 * len(files) > len(leaves)), key=natural_order)
    if names:
        yield Place(folder, "moments", tuple(Footage(name, tuple(found[name])) for name in names))


def _pictures(folder: Path) -> tuple[Path, ...]:
    """Return the pictures of a folder, or else of the one inside that is made for them, in order."""
    for inner in (".", *_INNER):
        listed = list_folder(folder / inner)
        names = [name for name in listed if is_picture(name)] or [n for n in listed if _ending(n) in _FOREIGN]
        if names:
            return tuple(folder / inner / name for name in sorted(names, key=natural_order))
    return ()


def _ending(name: str) -> str:
    """Return the ending of a name in small letters; none of hidden files, such as the ._cam0.mp4 that macOS leaves."""
    return name.rpartition(".")[2].lower() if "." in name and not name.startswith(".") else ""
