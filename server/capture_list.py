"""The captures that lie in the folders which the server may read, for people to choose from.

A look is bounded in folders, files and depth, decodes no picture, and asks again only about captures that have changed.
"""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import is_storable
from hgs_core.capture.cameras.rig import CameraFormat
from hgs_core.capture.footage import FEWEST_VIDEOS, is_video, natural_order
from hgs_core.capture.layout import calibration, outline
from hgs_core.capture.open import open_capture
from hgs_core.capture.video import announced_length
from server.capture_folders import CaptureFolders
from server.encodable import encodable
from server.problems import ProblemError

__all__ = ["CaptureList"]

_DEEPEST = 3  # folders below one that the server may read
_MOST_FOLDERS = 2000  # that one look goes into
_MOST_CAPTURES = 300
_MOST_FILES = 20_000  # of one folder; its name alone says what a capture is
_UNREADABLE = "the capture cannot be read; the server's log says more"
_LARGEST_TABLE = 64 << 20  # bytes of a JSON file that is read for its cameras

log = logging.getLogger("hgs.server")


@dataclass(frozen=True)
class _Folder:
    """What a look finds in one folder."""

    files: dict[str, tuple[int, int]]  # size in bytes and time of change in ns, by name
    folders: list[str]


@dataclass(frozen=True)
class _Capture:
    """A folder with a file of cameras, or with videos whose poses a job can find, or an upload with neither."""

    files: dict[str, tuple[int, int]]
    cameras: tuple[CameraFormat, Path] | None = None
    changed: tuple[int, int] = (0, 0)  # size and time of change of the file of cameras, which may lie deeper
    videos: tuple[str, ...] = ()  # without poses


@dataclass
class CaptureList:
    """Finds the captures; safe to use from several threads, which look one after the other."""

    folders: CaptureFolders
    _known: dict[Path, tuple[int, dict[str, Any]]] = field(default_factory=dict)  # with a mark of their files
    _one_look: threading.Lock = field(default_factory=threading.Lock)

    def describe(self) -> dict[str, Any]:
        """Return the answer of `GET /v1/captures`."""
        with self._one_look:
            known, complete = dict[Path, tuple[int, dict[str, Any]]](), True
            captures: list[dict[str, Any]] = []
            for name, path, found in self._candidates():
                if found is None or len(captures) == _MOST_CAPTURES:
                    complete = False
                    break
                mark = hash((found.cameras and found.cameras[1], found.changed, tuple(sorted(found.files.items()))))
                before, described = self._known.get(path, (0, {}))
                if not described or before != mark:
                    described = self._described(path, found)
                known[path] = mark, described
                captures.append({"capture": str(path), "name": name} | described)
            self._known = known
        roots = [{"path": str(folder), "exists": folder.is_dir()} for folder in self.folders.folders]
        answer: dict[str, Any] = encodable({"captures": captures, "folders": roots, "complete": complete})
        return answer

    def _described(self, path: Path, found: _Capture) -> dict[str, Any]:
        try:
            self.folders.require_inner_links(path)  # before anything is opened
        except (InputError, ProblemError) as error:
            return {"layout": None, "cameras": [], "frames": None, "seconds": None, "problem": str(error)}
        return _described(path, found)

    def _candidates(self) -> Iterator[tuple[str, Path, _Capture | None]]:
        """Yield the captures in order; None last where a bound is met."""
        seen: set[Path] = set()
        for root in self.folders.folders:
            yield from self._below(root, 0, root, seen)
        uploaded = self.folders.uploaded
        uploads = None if uploaded is None else _look(uploaded)
        if uploaded is None or uploads is None:
            return
        for name in sorted(uploads.folders):
            found = list(self._below(uploaded / name, 1, uploaded, seen))
            yield from found or [(name, uploaded / name, _Capture({}))]

    def _below(
        self, start: Path, start_depth: int, root: Path, seen: set[Path]
    ) -> Iterator[tuple[str, Path, _Capture | None]]:
        """Yield the captures in a folder, the folder itself among them, by their paths below `root`."""
        waiting = [(start, start_depth)]
        while waiting:
            path, depth = waiting.pop()
            if path in seen:
                continue
            seen.add(path)
            if len(seen) > _MOST_FOLDERS:
                yield "", path, None
                return
            found = _look(path)
            if found is None:
                continue
            capture = _capture(path, found)
            if capture is not None:
                yield path.relative_to(root).as_posix() if path != root else root.name, path, capture
            elif depth < _DEEPEST:
                inside = (self._inside(path / name) for name in sorted(found.folders, reverse=True))
                waiting += [(below, depth + 1) for below in inside if below is not None]

    def _inside(self, path: Path) -> Path | None:
        """Return a folder as a job would name it, or None if a link leads out of what the server may read."""
        try:
            resolved = path.resolve()
        except (OSError, RuntimeError):
            return None
        return path if self.folders.allows(resolved) and is_storable(str(path)) else None


def _look(path: Path) -> _Folder | None:
    """Return what is in a folder, as far as the bound; None where it cannot be read."""
    files: dict[str, tuple[int, int]] = {}
    folders: list[str] = []
    try:
        with os.scandir(path) as entries:
            for number, entry in enumerate(entries):
                if number == _MOST_FILES:
                    break
                if entry.name.startswith(".") or not is_storable(entry.name):
                    continue
                if entry.is_dir():
                    folders.append(entry.name)
                elif entry.is_file():
                    status = entry.stat()
                    files[entry.name] = status.st_size, status.st_mtime_ns
    except OSError:
        return None
    return _Folder(files, folders)


def _capture(path: Path, found: _Folder) -> _Capture | None:
    """Return what is known of a folder that seems to be a capture; None if it does not."""
    try:
        cameras = next(calibration(path), None)
        if cameras is None:
            videos = tuple(sorted((name for name in found.files if is_video(name)), key=natural_order))
            return _Capture(found.files, videos=videos) if len(videos) >= FEWEST_VIDEOS else None
        status = cameras[1].stat()
    except (InputError, OSError):
        return None
    return _Capture(found.files, cameras, (status.st_size, status.st_mtime_ns))


def _described(path: Path, found: _Capture) -> dict[str, Any]:
    if found.cameras is None:
        return _described_videos(path, found.videos) if found.videos else _described_upload(path)
    camera_format, file = found.cameras
    description: dict[str, Any] = {"layout": camera_format.name, "cameras": [], "frames": None, "seconds": None}
    try:
        tables = [name for name, (size, _) in found.files.items() if name.endswith(".json") and size > _LARGEST_TABLE]
        if tables:
            raise InputError(path / tables[0], f"is larger than {_LARGEST_TABLE >> 20} MiB", "it is too large to list")
        told = outline(path, camera_format, file)
    except InputError as error:
        return description | {"problem": " ".join(str(error).split())}
    except Exception:  # whatever a damaged file brings about: the others are there
        log.exception("capture %s cannot be described", path)
        return description | {"problem": _UNREADABLE}
    return description | {
        "cameras": list(told.cameras), "frames": told.frames, "seconds": told.seconds, "problem": None,
    }  # fmt: skip


def _described_videos(path: Path, videos: tuple[str, ...]) -> dict[str, Any]:
    description = {"layout": "videos without poses", "cameras": [Path(name).stem for name in videos]}
    try:
        frames, rate = announced_length(path / videos[0])
    except InputError as error:
        return description | {"frames": None, "seconds": None, "problem": " ".join(str(error).split())}
    return description | {
        "frames": frames, "seconds": frames / rate if frames is not None and rate is not None else None,
        "problem": None,
    }  # fmt: skip


def _described_upload(path: Path) -> dict[str, Any]:
    """Say what is missing in an upload that is no capture."""
    problem = _UNREADABLE
    try:
        open_capture(path)
    except InputError as error:
        problem = " ".join(str(error).split())
    except Exception:  # whatever a damaged file brings about: the others are there
        log.exception("upload %s cannot be described", path)
    return {"layout": None, "cameras": [], "frames": None, "seconds": None, "problem": problem}
