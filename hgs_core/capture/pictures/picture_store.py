"""The decoded pictures of a capture on disk, for random access to more of them than memory holds."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import threading
from collections.abc import Collection, Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.system_errors import as_input_error

__all__ = ["PictureStore"]

_MARK = "pictures.txt"  # the capture and the boot that the files are of
_BOOT = Path("/proc/sys/kernel/random/boot_id")
_SPARE = 1 << 28  # bytes of a disk that stay free

Picture = tuple[int, int]
"""A camera and a frame."""


class PictureStore:
    """The pictures of a capture in a folder, one file each, at most `limit` bytes of them.

    A picture is stored as it is trained with: upright, straight and reduced, [H, W, 3] bytes. Files are read with
    `pread` and not mapped: a full disk is then an error and no signal, and the memory of a process stays its own. They
    are not synchronised to the disk, and so hold for one boot of the machine. Safe for several threads and processes.
    """

    def __init__(self, folder: Path, limit: int, fingerprint: str) -> None:
        """Take over the files of the same fingerprint; the first `make_room` removes others.

        Raises:
            InputError: the folder cannot be read.
        """
        self.folder, self.limit = folder, limit
        self._held: dict[Picture, int] = {}  # bytes
        self._lock = threading.Lock()
        boot = _BOOT.read_text().strip() if _BOOT.exists() else secrets.token_hex(8)
        self._mark = f"{fingerprint}\n{boot}\n"
        try:
            if self._is_of_this_capture():
                for path in folder.glob("*/*.rgb"):
                    self._held[int(path.parent.name), int(path.stem)] = path.stat().st_size
        except OSError as error:
            raise as_input_error(error, folder) from error

    @property
    def bytes_held(self) -> int:
        """Bytes of the files."""
        return sum(self._held.values())

    def __contains__(self, picture: Picture) -> bool:
        """Return whether a picture is stored."""
        return picture in self._held

    def read(self, camera: int, frame: int, height: int, width: int) -> npt.NDArray[np.uint8] | None:
        """Return a picture [H, W, 3], read-only, or None if it is not stored, or no longer."""
        if (camera, frame) not in self._held:
            return None
        picture = np.empty((height, width, 3), np.uint8)
        try:
            with self._path(camera, frame).open("rb", buffering=0) as file:
                if file.readinto(picture.data) == picture.nbytes:
                    picture.flags.writeable = False
                    return picture
        except OSError:  # another process has made room, or the disk fails: the video still has it
            pass
        with self._lock:
            self._held.pop((camera, frame), None)
        return None

    def expect(self, pictures: Iterable[Picture]) -> None:
        """Have the system read pictures ahead from the disk, while this process computes."""
        if not hasattr(os, "posix_fadvise"):
            return
        for camera, frame in pictures:
            if (camera, frame) in self._held:
                try:
                    with self._path(camera, frame).open("rb", buffering=0) as file:
                        os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_WILLNEED)
                except OSError:  # `read` will find out
                    continue

    def write(self, camera: int, frame: int, picture: npt.NDArray[np.uint8]) -> None:
        """Store a picture [H, W, 3], whole or not at all.

        Raises:
            InputError: it cannot be written; names the file and a cure.
        """
        path = self._path(camera, frame)
        temporary = path.with_suffix(f".{secrets.token_hex(4)}.tmp")
        try:
            path.parent.mkdir(exist_ok=True)
            with temporary.open("xb", buffering=0) as file:
                rest = memoryview(np.ascontiguousarray(picture).data).cast("B")
                while rest:
                    rest = rest[file.write(rest) :]
            temporary.replace(path)
        except OSError as error:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise as_input_error(error, path) from error
        with self._lock:
            self._held[camera, frame] = picture.nbytes

    def make_room(self, needed: int, kept: Collection[Picture]) -> None:
        """Remove other pictures than `kept` until `needed` more bytes are within the limit, and on the disk.

        Raises:
            InputError: the disk has no room for them, or the folder cannot be written.
        """
        with self._lock:
            try:
                self._begin()
            except OSError as error:
                raise as_input_error(error, self.folder) from error
            others = [picture for picture in self._held if picture not in kept]
            excess = self.bytes_held + needed - self.limit
            while others and (excess > 0 or self._lacking(needed) > 0):
                picture = others.pop()
                excess -= self._held.pop(picture)
                self._path(*picture).unlink(missing_ok=True)
        lacking = self._lacking(needed)
        if lacking > 0:
            free = (needed - lacking) / 1e9
            problem = f"the decoded pictures take {needed / 1e9:.1f} GB, and {max(0.0, free):.1f} GB are free"
            fitting = max(0, int(free / 1.08))  # GiB
            cure = (
                f"make room, or --downscale 2, or --set capture.picture_disk_gib={fitting}: as much is held at a time"
            )
            raise InputError(self.folder, problem, cure)

    def _is_of_this_capture(self) -> bool:
        mark = self.folder / _MARK
        return mark.exists() and mark.read_text() == self._mark

    def _begin(self) -> None:
        if not self._is_of_this_capture():
            shutil.rmtree(self.folder, ignore_errors=True)
            self._held.clear()
            self.folder.mkdir(parents=True, exist_ok=True)
            (self.folder / _MARK).write_text(self._mark)

    def _lacking(self, needed: int) -> int:
        return needed + _SPARE - shutil.disk_usage(self.folder).free

    def _path(self, camera: int, frame: int) -> Path:
        return self.folder / str(camera) / f"{frame}.rgb"
