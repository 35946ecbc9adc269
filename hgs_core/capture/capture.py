"""The capture that every loader returns: fixed cameras, a clock, and pictures on demand."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.progress import ProgressCallback, silent
from hgs_core.capture.held_pictures import FrameSource, HeldPictures
from hgs_core.capture.pictures.depth_files import DepthFiles
from hgs_core.scene.camera import Camera

__all__ = ["CameraVideo", "Capture", "files_fingerprint", "frames_in"]


@dataclass(frozen=True)
class CameraVideo:
    """The video of a camera."""

    path: Path
    stamps: npt.NDArray[np.float64]  # [N] of its frames, seconds of its own
    interlaced: bool = False  # whether it says that a picture is of two moments, half a period apart


class Capture:
    """A multi-view video: cameras that never move, on one clock; or photographs of a still scene, all of one moment.

    Pictures are decoded on demand into a cache of bounded size, or ahead by `hold`. All methods are safe to call from
    several threads.
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
        mirrored: bool = False,
        videos: Sequence[CameraVideo | None] = (),  # one for each camera; None: it has pictures
        straightened: Sequence[bool] = (),  # whether each camera's lens bends; empty: none does
        depth: DepthFiles | None = None,
        mesh: Path | None = None,
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
        self.mirrored = mirrored  # whether all poses were reflections, and x of the world was turned: a guess
        self._videos = tuple(videos)
        self.straightened = tuple(straightened) or (False,) * len(names)  # whether pictures are made straight
        self.depth = depth  # given depth maps
        self.mesh = mesh  # a file of given triangles, in the world of the cameras
        self._source = source
        self._fingerprint = fingerprint
        self.cache_bytes = cache_bytes  # bytes of decoded pictures
        sizes = tuple((one.name, one.width, one.height, one.fx, one.fy, one.cx, one.cy) for one in self.cameras)
        key = fingerprint, sizes, self._numbers.tobytes(), cache_bytes
        self._pictures = HeldPictures.shared(key, source, self.cameras, len(self.times), cache_bytes)

    @property
    def seconds(self) -> float:
        """How long it is, from the first frame to the last."""
        return float(self.times[-1] - self.times[0])

    def frames_in(self, seconds: float) -> int:
        """Return how many frames `seconds` take, rounded: at least one, at most all."""
        return frames_in(seconds, self.times)

    def frame(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        """Return one picture [H, W, 3], sRGB, read-only.

        Raises:
            InputError: the picture is missing, unreadable or of another size than its camera's.
            IndexError: no such camera or frame.
        """
        self._check(camera, frame)
        return self._pictures.picture(camera, frame)

    def lines(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        """Return the brightness of one picture [H, W] as its file has it: neither straightened nor made smaller.

        Raises:
            InputError: the picture is missing or unreadable.
            IndexError: no such camera or frame.
        """
        self._check(camera, frame)
        return self._pictures.lines(camera, frame)

    @property
    def room(self) -> int:
        """Bytes of decoded pictures that can be held for random access."""
        return self._pictures.room

    def keep_on_disk(self, folder: Path, limit: int) -> None:
        """Let `hold` keep at most `limit` bytes of pictures in a folder, if they do not all fit in memory.

        Raises:
            InputError: the folder cannot be read.
        """
        self._pictures.keep_on_disk(folder, limit, self._fingerprint)

    def hold(self, cameras: Sequence[int], frames: Sequence[int], progress: ProgressCallback = silent) -> None:
        """Decode pictures ahead, on all cores, for `frame` to give in any order; nothing is done where they do not fit.

        Progress is reported by pictures, as the stage `frames`.

        Raises:
            InputError: a picture is unreadable or of another size than its camera's, or the disk is full.
            StageStopped: the callback wishes so.
        """
        self._pictures.hold(cameras, frames, progress)

    def expect(self, pictures: Iterable[tuple[int, int]]) -> None:
        """Have held pictures (camera, frame) read from the disk ahead, where that is where they are."""
        self._pictures.expect(pictures)

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


def frames_in(seconds: float, times: npt.NDArray[np.float64]) -> int:
    """Return how many of the frames at `times` [F], seconds, a stretch takes, rounded: at least one, at most all."""
    frames = len(times)
    if frames == 1:
        return 1
    return int(np.clip(round(seconds / float(times[-1] - times[0]) * (frames - 1)), 1, frames))
