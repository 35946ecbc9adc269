"""Capture folders below the readable roots, with their cameras and lengths from lists and headers.

For the limited process of `server.captures.capture_reader` alone: the API's own process opens no file of a capture.
A scan is bounded in folders, files and depth. Of a capture one picture is decoded, of one that is chosen one of each
camera.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import is_storable
from hgs_core.capture.cameras.camera_formats import calibration
from hgs_core.capture.cameras.rig import CameraFormat
from hgs_core.capture.footage import FEWEST_VIDEOS, is_video, natural_order
from hgs_core.capture.load import Outline, outline
from hgs_core.capture.open import open_capture
from hgs_core.capture.pictures.announced_length import announced_length
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_preview import camera_picture, capture_preview

__all__ = ["FoundCapture", "camera_pictures", "describe_capture", "find_captures", "require_bounded_tables"]

_VIDEOS_ALONE = "videos without poses"
_MOST_CAPTURES = 300
_DEEPEST = 3  # levels below a readable root
_MOST_PICTURES = 256  # cameras
_MOST_FOLDERS = 2000  # folders per scan
_MOST_FILES = 20_000  # files per folder; the names alone reveal a capture
_LARGEST_TABLE = 64 << 20  # largest file that is parsed as a whole, bytes
_TABLES = (".json", ".toml", ".yml", ".yaml", ".xml")
_TABLE_FOLDERS = 2  # levels below the capture that may contain camera files


@dataclass(frozen=True)
class FoundCapture:
    """A folder that seems to be a capture, or any upload, judged by its file names."""

    name: str
    path: Path
    mark: str  # changes when its files change
    layout: str | None  # None: an upload that is not a capture
    cameras: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Folder:
    """Files and folders of one folder."""

    files: dict[str, tuple[int, int]]  # size in bytes and time of change in ns, by name
    folders: dict[str, int]  # time of change in ns, by name


@dataclass(frozen=True)
class _Content:
    """A camera file, or videos without poses, or neither in an upload."""

    cameras: tuple[CameraFormat, Path] | None = None
    videos: tuple[str, ...] = ()  # names of videos that have no poses

    def found(self, name: str, path: Path, folder: _Folder) -> FoundCapture:
        """Return the capture made of these files."""
        if self.cameras is not None:
            return FoundCapture(name, path, _mark(folder, self.cameras[1]), self.cameras[0].name)
        layout = _VIDEOS_ALONE if self.videos else None
        return FoundCapture(name, path, _mark(folder), layout, tuple(Path(video).stem for video in self.videos))


def find_captures(folders: CaptureFolders) -> tuple[list[FoundCapture], bool]:
    """Return the captures by folder and name, and whether the list is complete."""
    found: list[FoundCapture] = []
    for capture in _candidates(folders):
        if capture is None or len(found) == _MOST_CAPTURES:
            return found, False
        found.append(capture)
    return found, True


def describe_capture(path: Path, folders: CaptureFolders) -> dict[str, Any]:
    """Return the description of a capture for `GET /v1/captures`, with a null problem.

    Raises:
        InputError: it cannot be read, or is not a capture.
        ProblemError: one of its links leads outside the folders.
    """
    layout, told = _outline(path, folders)
    return {
        "layout": layout,
        "cameras": list(told.cameras),
        "frames": told.frames,
        "seconds": told.seconds,
        "problem": None,
        **capture_preview(told.firsts[0], len(told.cameras), told.frames, told.seconds),
    }


def camera_pictures(path: Path, folders: CaptureFolders) -> Iterator[dict[str, Any]]:
    """Yield `camera` and `picture` of the cameras of a capture, at most of the first few hundred.

    Raises:
        InputError: as `describe_capture`.
        ProblemError: likewise.
    """
    _, told = _outline(path, folders)
    for camera, file in zip(told.cameras[:_MOST_PICTURES], told.firsts, strict=False):
        yield {"camera": camera, "picture": camera_picture(file)}


def _outline(path: Path, folders: CaptureFolders) -> tuple[str, Outline]:
    """Return the layout and the outline of a capture, after a check of its links."""
    folders.require_inner_links(path)  # must come first
    require_bounded_tables(path)
    content = _content(path, _look(path) or _Folder({}, {})) or _Content()
    if content.cameras is not None:
        camera_format, file = content.cameras
        return camera_format.name, outline(path, camera_format, file)
    if not content.videos:
        open_capture(path)
        raise InputError(path, "is not a capture")  # unless it has just become one
    length = announced_length(path / content.videos[0])
    videos = [path / name for name in content.videos]
    return _VIDEOS_ALONE, Outline(tuple(one.stem for one in videos), tuple(videos), length.frames, length.seconds)


def require_bounded_tables(capture: Path) -> None:
    """Reject camera files that would take too much memory to parse.

    Raises:
        InputError: one is too large.
    """
    waiting = [(capture, 0)]
    while waiting:
        folder, depth = waiting.pop()
        here = _look(folder)
        for name, (size, _) in here.files.items() if here is not None else ():
            if size > _LARGEST_TABLE and name.lower().endswith(_TABLES):
                raise InputError(
                    folder / name,
                    f"is larger than {_LARGEST_TABLE >> 20} MiB, too large for a file of cameras",
                    "keep only the cameras and their frames in it, or rename it if it is not a camera file",
                )
        if here is not None and depth < _TABLE_FOLDERS:
            waiting += [(folder / name, depth + 1) for name in here.folders]


def _candidates(folders: CaptureFolders) -> Iterator[FoundCapture | None]:
    """Yield the captures in order; a final None means that a bound was reached."""
    seen: set[Path] = set()
    for root in folders.folders:
        yield from _below(folders, root, 0, root, seen)
    uploaded = folders.uploaded
    uploads = None if uploaded is None else _look(uploaded)
    if uploaded is None or uploads is None:
        return
    for name in sorted(uploads.folders):
        found = list(_below(folders, uploaded / name, 1, uploaded, seen))
        folder = _look(uploaded / name) or _Folder({}, {})
        yield from found or [_Content().found(name, uploaded / name, folder)]


def _below(
    folders: CaptureFolders, start: Path, start_depth: int, root: Path, seen: set[Path]
) -> Iterator[FoundCapture | None]:
    """Yield the captures in a folder, including the folder itself, with paths relative to `root`."""
    waiting = [(start, start_depth)]
    while waiting:
        path, depth = waiting.pop()
        if path in seen:
            continue
        seen.add(path)
        if len(seen) > _MOST_FOLDERS:
            yield None
            return
        found = _look(path)
        if found is None:
            continue
        content = _content(path, found)
        if content is not None:
            name = path.relative_to(root).as_posix() if path != root else root.name
            yield content.found(name, path, found)
        elif depth < _DEEPEST:
            inside = (_inside(folders, path / name) for name in sorted(found.folders, reverse=True))
            waiting += [(below, depth + 1) for below in inside if below is not None]


def _inside(folders: CaptureFolders, path: Path) -> Path | None:
    """Return a folder under the name that jobs use, or None if a link leads outside the readable folders."""
    try:
        resolved = path.resolve()
    except (OSError, RuntimeError):
        return None
    return path if folders.allows(resolved) and is_storable(str(path)) else None


def _look(path: Path) -> _Folder | None:
    """Return the content of a folder, up to the bound; None if it cannot be read."""
    files: dict[str, tuple[int, int]] = {}
    folders: dict[str, int] = {}
    try:
        with os.scandir(path) as entries:
            for number, entry in enumerate(entries):
                if number == _MOST_FILES:
                    break
                if entry.name.startswith(".") or not is_storable(entry.name):
                    continue
                if entry.is_dir():
                    folders[entry.name] = entry.stat().st_mtime_ns
                elif entry.is_file():
                    status = entry.stat()
                    files[entry.name] = status.st_size, status.st_mtime_ns
    except OSError:
        return None
    return _Folder(files, folders)


def _content(path: Path, found: _Folder) -> _Content | None:
    """Return the content of a folder that seems to be a capture, or None."""
    try:
        cameras = next(calibration(path), None)
    except (InputError, OSError):
        return None
    if cameras is not None:
        return _Content(cameras)
    videos = tuple(sorted((name for name in found.files if is_video(name)), key=natural_order))
    return _Content(videos=videos) if len(videos) >= FEWEST_VIDEOS else None


def _mark(found: _Folder, cameras: Path | None = None) -> str:
    """Return a mark that changes with a capture's files, including a camera file in a subfolder."""
    try:
        status = None if cameras is None else cameras.stat()
    except OSError:
        status = None
    deeper = None if status is None else (str(cameras), status.st_size, status.st_mtime_ns)
    everything = deeper, sorted(found.files.items()), sorted(found.folders.items())
    return hashlib.sha256(repr(everything).encode()).hexdigest()
