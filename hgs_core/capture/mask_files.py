"""Given masks of what moves: one picture per camera and frame, `<camera>/<FFFF>.png`, where any value above 0 moves.

This is what segmentation tools such as SAM 2 or Track Anything write: 0 and 255, or the number of an object, as grey
values or palette entries (docs/captures.md).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.picture import check_size, numbered_pictures, read_mask
from hgs_core.scene.camera import Camera

__all__ = ["MaskFiles", "find_masks"]


@dataclass(frozen=True)
class MaskFiles:
    """The mask files of some cameras, one per frame."""

    files: Mapping[str, Sequence[Path]]  # by the camera's name
    folder: Path | None = None  # where they are, for people

    def read(self, camera: Camera, frame: int) -> npt.NDArray[np.bool_] | None:
        """Return the mask [H, W] of a frame, or None if none are given for the camera.

        Raises:
            InputError: the file is missing, unreadable, or not of the camera's size.
        """
        files = self.files.get(camera.name)
        return None if files is None else read_mask(files[frame], camera)

    def sizes(self) -> list[tuple[Path, int]]:
        """Return the files and their sizes in bytes."""
        return [(path, path.stat().st_size) for files in self.files.values() for path in files]

    def notes(self, cameras: Sequence[Camera]) -> list[str]:
        """Say for which cameras masks are given, unless for none."""
        if not self.files:
            return []
        rest = [camera.name for camera in cameras if camera.name not in self.files]
        given = f"the masks of {', '.join(self.files)} are given, in {self.folder}"
        return [f"{given}; those of {', '.join(rest)} are computed" if rest else given]


def find_masks(folder: Path, cameras: Sequence[Camera], frames: int, *, required: bool = False) -> MaskFiles:
    """Return the masks in a folder with one folder per camera; those of a camera without a folder are not given.

    Raises:
        InputError: a camera's folder lacks a frame, or its first mask is unreadable or not of the camera's size; or,
            if masks are `required`, there is no folder of any camera.
    """
    found = {c.name: _files(folder / c.name, c, frames) for c in cameras if (folder / c.name).is_dir()}
    if required and not found:
        problem = "holds no masks of this capture" if folder.is_dir() else "the folder does not exist"
        names = ", ".join(camera.name for camera in cameras)
        raise InputError(folder, problem, f"it has one folder of PNG files for each camera of {names}")
    return MaskFiles(found, folder)


def _files(folder: Path, camera: Camera, frames: int) -> list[Path]:
    numbers = numbered_pictures(folder)
    for frame in range(frames):
        if frame not in numbers:
            cure = "number the masks from 0, one for each frame, or remove the folder to have them computed"
            raise InputError(folder, f"the mask of frame {frame} is missing", cure)
    check_size(numbers[0], camera)
    return [numbers[frame] for frame in range(frames)]
