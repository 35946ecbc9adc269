"""The files of a capture to send to a server: those of a folder or of an archive."""

from __future__ import annotations

import hashlib
import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from hgs_core.base.errors import InputError
from server.cli.archive import ARCHIVES, unpack
from server.http.problems import ProblemError
from server.uploads.names import FolderNames, normal_path
from server.uploads.upload_limits import UploadLimits

__all__ = ["CaptureFile", "archive_ending", "capture_files", "opened_capture", "upload_key"]

# What file managers and archivers leave behind; nobody's capture needs it.
_JUNK = re.compile(r"\..*|__MACOSX|Thumbs\.db|desktop\.ini|__pycache__", re.IGNORECASE)
_BLOCK = 1 << 20


@dataclass(frozen=True)
class CaptureFile:
    """A file to be sent."""

    path: str  # below the capture, as the server stores it
    file: Path
    size: int  # bytes

    def sha256(self) -> str:
        """Return the SHA-256 of the content, 64 hexadecimal digits."""
        digest = hashlib.sha256()
        with self.file.open("rb") as file:
            while block := file.read(_BLOCK):
                digest.update(block)
        return digest.hexdigest()


def archive_ending(source: Path) -> str:
    """Return how an archive's name ends; "" for a folder.

    Raises:
        InputError: there is neither.
    """
    if source.is_dir():
        return ""
    if not source.is_file():
        raise InputError(source, "does not exist", "give the folder of a capture, or an archive of one")
    ending = next((ending for ending in ARCHIVES if source.name.lower().endswith(ending)), None)
    if ending is None:
        raise InputError(source, "is neither a folder nor an archive", f"archives are {', '.join(ARCHIVES)}")
    return ending


@contextmanager
def opened_capture(source: Path, limits: UploadLimits) -> Iterator[tuple[str, Path]]:
    """Yield a capture's name and folder; an archive is unpacked into a temporary one, as far as `limits` go.

    Raises:
        InputError: there is neither a folder nor an archive, or the archive holds what no upload may.
    """
    ending = archive_ending(source)
    if not ending:
        yield source.resolve().name or "capture", source
        return
    with tempfile.TemporaryDirectory(prefix="hgs-archive-") as temporary:
        folder = Path(temporary)
        unpack(source, folder, limits)
        inside = [path for path in folder.iterdir() if not _JUNK.fullmatch(path.name)]
        only = inside[0] if len(inside) == 1 and inside[0].is_dir() else folder
        yield source.name[: -len(ending)] or "capture", only


def capture_files(folder: Path) -> list[CaptureFile]:
    """Return the files of a capture, by their paths; hidden ones are left out.

    Raises:
        InputError: a name that no upload may have, a link to a folder, something that is no file, or no file at all.
    """
    names, found = FolderNames(), []
    for path in _below(folder):
        try:
            stored = normal_path(path.relative_to(folder).as_posix())
            names.add(stored)
        except ProblemError as problem:
            raise InputError(path, problem.detail) from problem
        found.append(CaptureFile(stored, path, path.stat().st_size))
    if not found:
        raise InputError(folder, "the folder is empty", "give the folder of a capture")
    return found


def upload_key(files: list[CaptureFile]) -> str:
    """Return the key by which a later client finds the same upload (docs/upload.md)."""
    lines = sorted((file.path.encode(), file.size) for file in files)
    return hashlib.sha256(b"".join(path + b"\t%d\n" % size for path, size in lines)).hexdigest()


def _below(folder: Path) -> Iterator[Path]:
    try:
        with os.scandir(folder) as scan:
            entries = sorted(scan, key=lambda entry: entry.name)
    except OSError as error:
        raise InputError(folder, f"cannot be read ({error.strerror})", "make the folder readable") from error
    for entry in entries:
        if _JUNK.fullmatch(entry.name):
            continue
        if entry.is_dir(follow_symlinks=False):
            yield from _below(Path(entry.path))
        elif entry.is_file():  # a link to a file is sent as that file
            yield Path(entry.path)
        else:
            raise InputError(entry.path, "is no file, or a link to a folder", "put the files themselves there")
