"""The reference of a run's scores: true pictures and motion masks."""

from __future__ import annotations

import dataclasses
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor

from hgs_core.base.errors import InputError
from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import (
    check_size,
    numbered_pictures,
    picture_size,
    read_mask,
    read_picture,
    reduced_mask,
    reduced_picture,
)
from hgs_core.decompose.background import Background, estimate_background, moving_pixels
from hgs_core.scene.camera import Camera
from hgs_core.train.targets import as_target, target_picture

__all__ = ["Truth"]


class Truth:
    """The true pictures and masks of some cameras: from folders where they are given, else from the capture.

    A folder has one PNG file per frame in `<camera>/<number>.png`; the number is the index of the frame, from 0, with
    or without leading zeros (0000.png). The files have the size of the camera's pictures; those of a run that reduced
    its capture are reduced like it. A mask is any picture; what is above 0 moves.
    """

    def __init__(
        self,
        capture: Capture,
        cameras: Sequence[int],  # indices into the capture's
        *,
        pictures: Path | None,
        masks: Path | None,
        downscale: int,  # reduction factor of the capture
        reductions: Mapping[str, int] = MappingProxyType({}),  # camera -> its own reduction factor
    ) -> None:
        """Find the files of the cameras and read all headers, so that scoring does not stop half-way.

        Raises:
            InputError: a folder or file is missing, unreadable, or of another size than its camera's.
        """
        self._capture = capture
        factors = [reductions.get(camera.name, downscale) for camera in capture.cameras]
        self._pictures = _files(capture, cameras, pictures, "picture", factors) if pictures is not None else {}
        self._masks = _files(capture, cameras, masks, "mask", factors) if masks is not None else {}
        self.of_pictures = "capture" if pictures is None else "given"
        """Where the pictures are from."""
        self._backgrounds: dict[int, Background] = {}
        self._lock = threading.Lock()
        own = masks is None and any(capture.mask(camera, 0) is not None for camera in cameras)
        several = len(capture.times) > 1
        self.of_masks = "given" if masks is not None else "capture" if own else "automatic" if several else None
        """Where the masks are from; None if there are none: at a single moment nothing moves."""

    def picture(self, camera: int, frame: int) -> Tensor:
        """Return the true picture [3, H, W], float32 in [0, 1].

        Raises:
            InputError: the file is missing or unreadable.
        """
        size = self._capture.cameras[camera]
        if camera not in self._pictures:
            return target_picture(self._capture, camera, frame, size)
        return as_target(torch.from_numpy(self._levels(camera, frame)), size)

    def moving(self, camera: int, frame: int) -> Tensor | None:
        """Return the motion mask [H, W] bool, or None if there is none for this camera.

        Automatic ones say where a frame differs from what the camera sees most of the time, in the true pictures alone:
        they are the same for all runs that are scored against these.

        Raises:
            InputError: the file is missing or unreadable.
        """
        if self.of_masks == "automatic":
            return torch.from_numpy(moving_pixels(self._levels(camera, frame), self._background(camera)))
        if camera not in self._masks:
            mask = self._capture.mask(camera, frame)
        else:
            path, stored = self._masks[camera][frame]
            mask = reduced_mask(read_mask(path, stored), self._capture.cameras[camera])
        return None if mask is None else torch.from_numpy(np.array(mask))

    def _background(self, camera: int) -> Background:
        with self._lock:
            if camera not in self._backgrounds:
                frames = len(self._capture.times)
                self._backgrounds = {camera: estimate_background(lambda frame: self._levels(camera, frame), frames)}
            return self._backgrounds[camera]

    def _levels(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        """Return the true picture [H, W, 3]; raises the errors of `picture`."""
        if camera not in self._pictures:
            return self._capture.frame(camera, frame)
        path, stored = self._pictures[camera][frame]
        return reduced_picture(read_picture(path, stored), self._capture.cameras[camera])


def _files(
    capture: Capture, cameras: Sequence[int], root: Path, kind: str, factors: Sequence[int]
) -> dict[int, list[tuple[Path, Camera]]]:
    """Return the file of every frame and the camera of its size, by camera."""
    if not root.is_dir():
        raise InputError(root, "is not a folder", f"give one with <camera>/<FFFF>.png, a {kind} for each frame")
    found = {}
    for camera in cameras:
        size = capture.cameras[camera]
        folder = root / size.name
        if not folder.is_dir():
            cure = "add it, or name the cameras to score with --cameras"
            raise InputError(folder, f"there are no {kind}s of camera {size.name}", cure)
        names = numbered_pictures(folder)
        for frame in range(len(capture.times)):
            if frame not in names:
                problem = f"the {kind} of frame {frame} is missing"
                raise InputError(folder, problem, f"there are {len(capture.times)} frames, numbered from 0000.png")
        frames = [names[frame] for frame in range(len(capture.times))]
        found[camera] = [(path, _stored(path, size, factors[camera])) for path in frames]
    return found


def _stored(path: Path, size: Camera, downscale: int) -> Camera:
    """Return the camera of the size of a file: that of the run's pictures, or of those it reduced."""
    width, height = picture_size(path)
    if (round(width / downscale), round(height / downscale)) == (size.width, size.height):
        return dataclasses.replace(size, width=width, height=height)
    check_size(path, size)
    return size
