"""What the loader of a layout finds, and how it becomes a `Capture`: masks chosen, pictures made smaller."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.cache import Neighbour
from hgs_core.capture.capture import Capture, files_fingerprint
from hgs_core.capture.mask_files import MaskFiles
from hgs_core.capture.picture import reduced_mask, reduced_picture
from hgs_core.scene.camera import Camera

__all__ = ["PictureSource", "Recording"]

_SMALLEST_SIDE = 16  # pixels; no side of a reduced picture may be shorter


class PictureSource(Protocol):
    """Where the pictures of a layout come from. Calls for the same camera never overlap; others may."""

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], Iterable[Neighbour]]:
        """Return the picture [H, W, 3], and up to `neighbours` others that had to be decoded on the way."""


@dataclass(frozen=True)
class Recording:
    """A capture as its files have it."""

    path: Path
    cameras: Sequence[Camera]  # undistorted, at the size of the pictures that `pictures` reads
    times: npt.NDArray[np.float64]  # [F] seconds
    pictures: PictureSource
    masks: MaskFiles
    files: Sequence[tuple[Path, int]]  # the pictures' and their sizes in bytes
    poses: Path
    notes: tuple[str, ...] = ()  # what was left out, for people

    def capture(self, *, downscale: int, cache_bytes: int) -> Capture:
        """Return the capture with pictures and masks reduced by a whole factor.

        Raises:
            InputError: as `Capture`, or a picture would become smaller than 16 pixels.
        """
        cameras = [camera.scaled(1 / downscale) for camera in self.cameras]
        for whole, camera in zip(self.cameras, cameras, strict=True):
            if downscale != 1 and min(camera.width, camera.height) < _SMALLEST_SIDE:
                problem = f"{downscale} is too much for the {whole.width}x{whole.height} pictures of {whole.name}"
                raise InputError("downscale", problem, f"no side may become shorter than {_SMALLEST_SIDE} pixels")
        masks, notes = self.masks, [*self.notes, *self.masks.notes(self.cameras)]
        if len(self.times) == 1 and masks.files:
            masks, notes = MaskFiles({}), [*self.notes, "the masks are not used: at one moment nothing moves"]
        fingerprint = files_fingerprint(self.path, [*self.files, *masks.sizes()], self.poses)
        return Capture(
            self.path,
            cameras,
            self.times,
            _Source(self, masks, cameras),
            fingerprint if downscale == 1 else f"{fingerprint}/{downscale}",
            cache_bytes=cache_bytes,
            notes=notes,
        )


class _Source:
    """The pictures and masks of a recording at the size that is asked for."""

    def __init__(self, recording: Recording, masks: MaskFiles, cameras: Sequence[Camera]) -> None:
        self._recording = recording
        self._masks = masks
        self._cameras = cameras

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], Iterable[Neighbour]]:
        picture, passed = self._recording.pictures.read(camera, frame, neighbours)
        size = self._cameras[camera]
        return reduced_picture(picture, size), [(index, reduced_picture(other, size)) for index, other in passed]

    def read_mask(self, camera: int, frame: int) -> npt.NDArray[np.bool_] | None:
        mask = self._masks.read(self._recording.cameras[camera], frame)
        return None if mask is None else reduced_mask(mask, self._cameras[camera])
