"""The capture that every loader returns: fixed cameras, a clock, and pictures on demand."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.picture_cache import FrameCache, Neighbour
from hgs_core.scene.camera import Camera

__all__ = ["CameraVideo", "Capture", "FrameSource", "files_fingerprint"]


@dataclass(frozen=True)
class CameraVideo:
    """The video of a camera."""

    path: Path
    stamps: npt.NDArray[np.float64]  # [N] of its frames, seconds of its own
    interlaced: bool = False  # whether it says that a picture is of two moments, half a period apart


class FrameSource(Protocol):
    """Where the pictures of a layout come from. Calls for the same camera never overlap; others may."""

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], Iterable[Neighbour]]:
        """Return the picture [H, W, 3], and up to `neighbours` others that had to be decoded on the way."""

    def read_mask(self, camera: int, frame: int) -> npt.NDArray[np.bool_] | None:
        """Return the given motion mask [H, W], or None if the capture has none for this camera."""

    def mask_file(self, camera: int, frame: int) -> Path | None:
        """Return the file of a given mask, or None if the capture has none for this camera."""


class Capture:
    """A multi-view video: cameras that never move, on one clock; or photographs of a still scene, all of one moment.

    Pictures are decoded on demand into a cache of bounded size. All methods are safe to call from several threads.
    """

    def __init__(
        self,
        path: Path,
        cameras: Sequence[Camera],
        times: npt.NDArray[np.float64],  # [F] seconds, increasing
        source: FrameSource,
        fingerprint: str,
        *,
        cache_bytes: int,
        moments: npt.NDArray[np.float64] | None = None,  # [C, F] seconds when frames were really taken; None: `times`
        numbers: npt.NDArray[np.int64] | None = None,  # [C, F] of frames in the cameras' own footage; None: in order
        notes: Sequence[str] = (),
        unaligned: Sequence[Path] = (),
        left_out: Sequence[str] = (),
        videos: Sequence[CameraVideo | None] = (),  # one for each camera; None: it has pictures
    ) -> None:
        """Loaders call this; everybody else calls `open_capture`.

        Raises:
            InputError: no camera, no frame, or two cameras of one name.
        """
        if not cameras:
            raise InputError(path, "the capture has no camera")
        if len(times) == 0:
            raise InputError(path, "the capture has no frame")
        names = [camera.name for camera in cameras]
        for name in names:
            if names.count(name) > 1:
                raise InputError(path, f"two cameras are called {name}", "give each camera its own name")
        self.path = path
        self.name = path.resolve().name
        self.cameras = tuple(cameras)
        self.times = np.array(times, np.float64)
        self.times.flags.writeable = False
        self._moments = np.broadcast_to(self.times, (len(names), len(self.times))) if moments is None else moments
        in_order = np.arange(len(self.times))
        self._numbers = np.broadcast_to(in_order, (len(names), len(in_order))) if numbers is None else numbers
        self.notes = tuple(notes)  # notes for people: omitted files, found masks
        self.unaligned = tuple(unaligned)  # the cameras' videos, where nothing says when they began; else none
        self.left_out = tuple(left_out)  # footage beside the cameras', of which there is no camera
        self._videos = tuple(videos)
        self._source = source
        self._fingerprint = fingerprint
        self.cache_bytes = cache_bytes  # bytes of decoded pictures
        self._cache = FrameCache(cache_bytes)
        self._locks = tuple(threading.Lock() for _ in cameras)
        # Each camera may fill its share of the cache with frames that were decoded only on the way to another.
        largest = max(camera.width * camera.height * 3 for camera in cameras)
        self._neighbours = max(0, cache_bytes // largest // len(cameras) - 1)

    @property
    def seconds(self) -> float:
        """How long it is, from the first frame to the last."""
        return float(self.times[-1] - self.times[0])

    def frames_in(self, seconds: float) -> int:
        """Return how many frames `seconds` take, rounded: at least one, at most all."""
        frames = len(self.times)
        if frames == 1:
            return 1
        return int(np.clip(round(seconds / self.seconds * (frames - 1)), 1, frames))

    def frame(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        """Return one picture [H, W, 3], sRGB, read-only.

        Raises:
            InputError: the picture is missing, unreadable or of another size than its camera's.
            IndexError: no such camera or frame.
        """
        self._check(camera, frame)
        picture = self._cache.get(camera, frame)
        if picture is not None:
            return picture
        with self._locks[camera]:
            picture = self._cache.get(camera, frame)  # another thread may have decoded it while this one waited
            if picture is None:
                picture, passed = self._source.read(camera, frame, self._neighbours)
                for index, neighbour in passed:
                    self._cache.put(camera, index, neighbour)
                picture.flags.writeable = False
                self._cache.put(camera, frame, picture)
        return picture

    def moment(self, camera: int, frame: int) -> float:
        """Return the second at which a camera took a frame: at most half a period from `times[frame]`.

        Raises:
            IndexError: no such camera or frame.
        """
        self._check(camera, frame)
        return float(self._moments[camera, frame])

    def number(self, camera: int, frame: int) -> int:
        """Return the index, from 0, of the shown frame in the camera's own footage: the number of given masks.

        Raises:
            IndexError: no such camera or frame.
        """
        self._check(camera, frame)
        return int(self._numbers[camera, frame])

    def video(self, camera: int) -> tuple[Path, float] | None:
        """Return a camera's video and its offset, seconds, to the capture's clock; None for a camera with pictures.

        Raises:
            IndexError: no such camera.
        """
        self._check(camera, 0)
        video = self._videos[camera] if self._videos else None
        if video is None:
            return None
        return video.path, float(np.median(self._moments[camera] - video.stamps[self._numbers[camera]]))

    def interlaced(self, camera: int) -> bool:
        """Return whether a camera's video says that each of its pictures is of two moments.

        Raises:
            IndexError: no such camera.
        """
        self._check(camera, 0)
        video = self._videos[camera] if self._videos else None
        return video is not None and video.interlaced

    def mask(self, camera: int, frame: int) -> npt.NDArray[np.bool_] | None:
        """Return the given mask [H, W], True = moves, or None if the capture gives none for this camera.

        Raises:
            InputError: the mask is unreadable or of another size than its camera's.
            IndexError: no such camera or frame.
        """
        self._check(camera, frame)
        return self._source.read_mask(camera, frame)

    def mask_file(self, camera: int, frame: int) -> Path | None:
        """Return the file of the given mask, or None if the capture gives none for this camera.

        Raises:
            IndexError: no such camera or frame.
        """
        self._check(camera, frame)
        return self._source.mask_file(camera, frame)

    def camera_index(self, name: str) -> int:
        """Return the index of the camera of that name; the file name of its video or photograph will do too.

        Raises:
            InputError: there is none; the message lists those there are.
        """
        names = [camera.name for camera in self.cameras]
        if name not in names and Path(name).stem in names:
            name = Path(name).stem
        if name not in names:
            raise InputError(self.path, f"there is no camera {name!r}", f"the cameras are {', '.join(names)}")
        return names.index(name)

    def fingerprint(self) -> str:
        """Return a hexadecimal digest that changes when the capture's files change in name, size or pose."""
        return self._fingerprint

    def _check(self, camera: int, frame: int) -> None:
        if not 0 <= camera < len(self.cameras):
            raise IndexError(f"camera {camera} is not in 0..{len(self.cameras) - 1}")
        if not 0 <= frame < len(self.times):
            raise IndexError(f"frame {frame} is not in 0..{len(self.times) - 1}")


def files_fingerprint(root: Path, files: Iterable[tuple[Path, int]], described_by: Iterable[Path]) -> str:
    """Return the SHA-256 of the names and sizes of `files` and of the content of the files `described_by`."""
    digest = hashlib.sha256()
    for path in described_by:
        digest.update(path.read_bytes())
    for name, size in sorted((_relative(path, root), size) for path, size in files):
        digest.update(f"\n{name} {size}".encode())
    return digest.hexdigest()


def _relative(path: Path, root: Path) -> str:
    return (path.relative_to(root) if path.is_relative_to(root) else path.resolve()).as_posix()
