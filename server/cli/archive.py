"""Unpacking an archive of a capture: files alone, with names that stay in their folder, as many as a server takes."""

from __future__ import annotations

import shutil
import stat
import tarfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO

import zstandard

from hgs_core.base.errors import InputError
from server.http.problems import ProblemError
from server.uploads.names import FolderNames, normal_path
from server.uploads.upload_limits import UploadLimits, bytes_for_people

__all__ = ["ARCHIVES", "unpack"]

ARCHIVES = (".zip", ".tar", ".tar.gz", ".tgz", ".tar.zst")

_BLOCK = 1 << 20


def unpack(archive: Path, folder: Path, limits: UploadLimits) -> None:
    """Unpack an archive into an empty folder, without hidden files.

    What comes out is bounded while it comes, whatever the archive says of itself.

    Raises:
        InputError: the archive is damaged or encrypted, holds a link or a name that no upload may have, or more files
            or bytes than the server takes.
    """
    target = _Target(archive, folder, limits, FolderNames())
    try:
        if archive.name.lower().endswith(".zip"):
            _unpack_zip(archive, target)
        else:
            _unpack_tar(archive, target)
    except (tarfile.TarError, zipfile.BadZipFile, zstandard.ZstdError, EOFError, NotImplementedError) as error:
        raise InputError(archive, f"cannot be unpacked ({error})", "make the archive again") from error
    except RuntimeError as error:  # zipfile's way to ask for a password
        raise InputError(archive, f"cannot be unpacked ({error})", "make it without a password") from error
    except OSError as error:
        if isinstance(error, zipfile.BadZipFile | tarfile.TarError) or error.strerror is None:
            raise InputError(archive, f"cannot be unpacked ({error})", "make the archive again") from error
        cure = f"{bytes_for_people(shutil.disk_usage(folder).free)} are free in {folder.parent}; TMPDIR names another"
        raise InputError(archive, f"cannot be unpacked ({error.strerror})", cure) from error


@dataclass
class _Target:
    """Where files go, and how much may come."""

    archive: Path
    folder: Path
    limits: UploadLimits
    names: FolderNames
    count: int = 0  # files
    total: int = 0  # bytes

    def write(self, name: str, content: IO[bytes], announced: int) -> None:
        """Write one file of so many bytes, unless it is hidden."""
        parts = [part for part in name.split("/") if part not in ("", ".")]
        if any((part.startswith(".") and part != "..") or part == "__MACOSX" for part in parts):
            return
        try:
            # Archives say ./a where they mean a; that they may not say /a or ../a is the point.
            path = normal_path(("/" if name.startswith("/") else "") + "/".join(parts))
            self.names.add(path)
            self.count += 1
            self.limits.check_upload(self.count, self.total)
            size = self._copy(path, content)
        except ProblemError as problem:
            raise InputError(self.archive, problem.detail) from problem
        if size != announced:
            raise EOFError(f"{size} of {announced} bytes of {path!r} are there")

    def refuse(self, name: str) -> None:
        """Refuse a member that is not a file."""
        problem = f"{name[:80]!r} is a link or a device"
        raise InputError(self.archive, problem, "pack the files themselves (tar --dereference)")

    def _copy(self, path: str, content: IO[bytes]) -> int:
        target = self.folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        size = 0
        with target.open("xb") as file:
            while block := content.read(_BLOCK):
                size += len(block)
                self.total += len(block)
                self.limits.check_file(path, size)
                self.limits.check_upload(self.count, self.total)
                file.write(block)
        return size


def _unpack_zip(archive: Path, target: _Target) -> None:
    with zipfile.ZipFile(archive) as opened:
        for entry in opened.infolist():
            if entry.is_dir():
                continue
            kind = stat.S_IFMT(entry.external_attr >> 16)
            if kind not in (0, stat.S_IFREG):
                target.refuse(entry.filename)
            with opened.open(entry) as content:
                target.write(entry.filename, content, entry.file_size)


def _unpack_tar(archive: Path, target: _Target) -> None:
    with _tar_stream(archive) as (stream, mode), tarfile.open(fileobj=stream, mode=mode) as opened:  # type: ignore[call-overload]
        for member in opened:
            if member.isdir():
                continue
            content = opened.extractfile(member) if member.isreg() else None
            if content is None:
                target.refuse(member.name)
            else:
                target.write(member.name, content, member.size)


@contextmanager
def _tar_stream(archive: Path) -> Iterator[tuple[IO[bytes], str]]:
    """Open a tar as a stream, which is read once from its beginning to its end."""
    with archive.open("rb") as file:
        name = archive.name.lower()
        if name.endswith(".zst"):
            with zstandard.ZstdDecompressor().stream_reader(file) as stream:
                yield stream, "r|"
        else:
            yield file, "r|gz" if name.endswith("gz") else "r|"
