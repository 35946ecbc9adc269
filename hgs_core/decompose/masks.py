"""The motion masks of a capture: given ones where it has them, automatic ones elsewhere."""

from __future__ import annotations

import os
import threading
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.atomic import replacing
from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.capture.capture import Capture
from hgs_core.decompose.background import estimate_background, moving_pixels, sample_frames

__all__ = ["MotionMasks", "motion_masks"]

_STAGE = "masks"
_SHARE_FRAMES = 16  # frames of each camera for the estimate of `MotionMasks.share`


class MotionMasks:
    """One mask per training picture. Automatic masks are held as deflated bits, given ones are read when asked for."""

    def __init__(self, capture: Capture, cameras: Sequence[int], automatic: Mapping[int, Sequence[bytes]]) -> None:
        """Hold the automatic masks `automatic[camera][frame]` (`_pack`); `motion_masks` and `load` call this."""
        self.cameras = tuple(cameras)
        self._capture = capture
        self._automatic = {camera: tuple(rows) for camera, rows in automatic.items()}

    def mask(self, camera: int, frame: int) -> npt.NDArray[np.bool_]:
        """Return the mask [H, W], True = moves.

        Raises:
            InputError: a given mask is unreadable.
            IndexError: no masks were made for this camera, or no such frame.
        """
        if camera not in self.cameras:
            raise IndexError(f"no masks were made for camera {camera}")
        if camera not in self._automatic:
            given = self._capture.mask(camera, frame)
            if given is None:
                raise InputError(self._capture.path, f"the masks of camera {camera} are gone", "restore the files")
            return given
        size = self._capture.cameras[camera]
        bits = np.frombuffer(zlib.decompress(self._automatic[camera][frame]), np.uint8)
        return np.unpackbits(bits, count=size.height * size.width).view(np.bool_).reshape(size.height, size.width)

    def share(self) -> float:
        """Return the share of the pixels that move, 0..1, from at most 16 frames of each camera."""
        frames = sample_frames(len(self._capture.times), _SHARE_FRAMES)
        return float(np.mean([self.mask(camera, frame).mean() for camera in self.cameras for frame in frames]))

    def changed(self, change: Callable[[int, int, npt.NDArray[np.bool_]], npt.NDArray[np.bool_]]) -> MotionMasks:
        """Return masks that `change(camera, frame, mask)` puts in the place of these, given ones too."""
        frames = range(len(self._capture.times))
        masks = {c: [_pack(change(c, frame, self.mask(c, frame))) for frame in frames] for c in self.cameras}
        return MotionMasks(self._capture, self.cameras, masks)

    def save(self, path: Path) -> None:
        """Write the automatic masks as an .npz file, which appears complete or not at all."""
        rows = [row for camera in sorted(self._automatic) for row in self._automatic[camera]]
        with replacing(path) as file:
            np.savez(
                file,
                fingerprint=np.array(self._capture.fingerprint()),
                cameras=np.array(self.cameras, np.int64),
                automatic=np.array(sorted(self._automatic), np.int64),
                sizes=np.array([len(row) for row in rows], np.int64),
                bits=np.frombuffer(b"".join(rows), np.uint8),
            )

    @classmethod
    def load(cls, path: Path, capture: Capture) -> MotionMasks:
        """Read a file that `save` wrote; given masks come from the capture.

        Raises:
            InputError: the file is missing, unreadable, or belongs to another capture.
        """
        try:
            with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
                data = {name: file[name] for name in ("fingerprint", "cameras", "automatic", "sizes", "bits")}
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise InputError(path, f"no readable masks ({error})", "run `initialise` again") from error
        if str(data["fingerprint"]) != capture.fingerprint():
            raise InputError(path, "the masks belong to another state of the capture", "run `initialise` again")
        automatic = [int(camera) for camera in data["automatic"]]
        frames = len(capture.times)
        if len(data["sizes"]) != frames * len(automatic) or int(data["sizes"].sum()) != len(data["bits"]):
            raise InputError(path, "the masks are incomplete", "run `initialise` again")
        ends = np.cumsum(data["sizes"])
        whole = data["bits"].tobytes()
        rows = [whole[end - size : end] for end, size in zip(ends, data["sizes"], strict=True)]
        by_camera = {camera: rows[i * frames : (i + 1) * frames] for i, camera in enumerate(automatic)}
        return cls(capture, [int(camera) for camera in data["cameras"]], by_camera)


def motion_masks(capture: Capture, cameras: Sequence[int], *, progress: ProgressCallback) -> MotionMasks:
    """Return the motion masks of the given cameras; no other camera is read. At a single moment nothing moves.

    Raises:
        InputError: a picture is missing or unreadable.
        StageStopped: the callback wishes so.
    """
    wanted = [camera for camera in cameras if capture.mask(camera, 0) is None]
    automatic: dict[int, list[bytes]] = {}
    progress(Progress(_STAGE, 0, len(wanted)))
    with ThreadPoolExecutor(min(4, os.cpu_count() or 1)) as pool:
        unwanted = threading.Event()
        jobs = [pool.submit(_automatic_masks, capture, camera, unwanted) for camera in wanted]
        try:
            for camera, job in zip(wanted, jobs, strict=True):
                automatic[camera] = job.result()
                progress(Progress(_STAGE, len(automatic), len(wanted)))
        except BaseException:
            unwanted.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return MotionMasks(capture, cameras, automatic)


def _automatic_masks(capture: Capture, camera: int, unwanted: threading.Event) -> list[bytes]:
    frames = len(capture.times)
    if frames == 1:
        size = capture.cameras[camera]
        return [_pack(np.zeros((size.height, size.width), bool))]
    background = estimate_background(lambda frame: capture.frame(camera, frame), frames)
    found: list[bytes] = []
    while len(found) < frames and not unwanted.is_set():
        found.append(_pack(moving_pixels(capture.frame(camera, len(found)), background)))
    return found


def _pack(mask: npt.NDArray[np.bool_]) -> bytes:
    return zlib.compress(np.packbits(mask).tobytes(), 1)
