"""The recording of a capture: pictures straightened and made smaller, frames by the common clock, masks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.capture import CameraVideo, Capture, files_fingerprint
from hgs_core.capture.lenses.lens import PINHOLE
from hgs_core.capture.lenses.straighten import WIDEST, StraightView
from hgs_core.capture.pictures.depth_files import DepthFiles
from hgs_core.capture.pictures.mask_files import MaskFiles
from hgs_core.capture.pictures.picture import reduced_mask, reduced_picture
from hgs_core.capture.pictures.picture_cache import Neighbour
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.time.clock import Clock
from hgs_core.scene.camera import Camera

__all__ = ["FrameReader", "Recording"]

_SMALLEST_SIDE = 16  # pixels; no side of a reduced picture may be shorter


class FrameReader(Protocol):
    """The pictures of one camera as they are on disk. Calls for one never overlap."""

    def read(self, index: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], Iterable[Neighbour]]:
        """Return frame `index` [H, W, 3], and up to `neighbours` others that had to be decoded on the way."""


@dataclass(frozen=True)
class Recording:
    """A capture as its files have it."""

    path: Path
    views: Sequence[StraightView]  # one for each camera
    readers: Sequence[FrameReader]  # one for each camera
    clock: Clock
    masks: MaskFiles
    files: Sequence[tuple[Path, int]]  # the pictures' and their sizes in bytes
    described_by: Sequence[Path]  # files of poses and times, all of whose content counts
    notes: tuple[str, ...] = ()  # omissions, for people
    unaligned: tuple[Path, ...] = ()  # the cameras' videos, where nothing says when they began
    left_out: tuple[str, ...] = ()  # footage beside the cameras', of which there is no camera
    mirrored: bool = False  # whether all poses were reflections
    depth: DepthFiles | None = None  # given depth maps
    mesh: Path | None = None  # a given mesh

    def capture(
        self,
        *,
        downscale: int,
        cache_bytes: int,
        notes: Sequence[str] = (),
        reductions: Mapping[str, int] = MappingProxyType({}),
    ) -> Capture:
        """Return the capture with pictures and masks reduced by whole factors, `reductions` by camera, and more notes.

        Raises:
            InputError: as `Capture`, or a picture would become smaller than 16 pixels.
        """
        names = [view.camera.name for view in self.views]
        for name in reductions:
            if name not in names:
                raise InputError("downscale", f"there is no camera {name!r}", f"the cameras are {', '.join(names)}")
        factors = [reductions.get(name, downscale) for name in names]
        shown = [view.camera.scaled(1 / factor) for view, factor in zip(self.views, factors, strict=True)]
        for view, camera, factor in zip(self.views, shown, factors, strict=True):
            if factor != 1 and min(camera.width, camera.height) < _SMALLEST_SIDE:
                size = f"{view.camera.width}x{view.camera.height}"
                problem = f"{factor} is too much for the {size} pictures of {camera.name}"
                raise InputError("downscale", problem, f"no side may become shorter than {_SMALLEST_SIDE} pixels")
        masks, said = self.masks, [*notes, *self.notes]
        cut = [view.camera.name for view in self.views if view.cut]
        if cut:
            said.append(f"straight pictures end {WIDEST:g} degrees from the axis; {', '.join(cut)} sees farther")
        if len(self.clock.times) == 1 and masks.files:
            masks = MaskFiles({})
            said.append("the masks are not used: at one moment nothing moves")
        said += masks.notes([view.camera.name for view in self.views])
        files, described_by = [*self.files, *masks.sizes()], [*self.described_by]
        if self.depth is not None:
            said += self.depth.notes([view.camera.name for view in self.views])
            files += self.depth.files()
            described_by.append(self.depth.scale.file)
        if self.mesh is not None:
            said.append(f"the mesh {self.mesh} is given")
            files.append((self.mesh, _mesh_size(self.mesh)))
        fingerprint = files_fingerprint(self.path, files, described_by)
        return Capture(
            self.path,
            shown,
            self.clock.times,
            _Source(self, masks, shown),
            "/".join([fingerprint, *_said_of(downscale, reductions)]),
            moments=self.clock.moments,
            numbers=self.clock.frames,
            cache_bytes=cache_bytes,
            notes=said,
            unaligned=self.unaligned,
            left_out=self.left_out,
            mirrored=self.mirrored,
            videos=[
                CameraVideo(r.path, r.seconds, r.interlaced) if isinstance(r, VideoReader) else None
                for r in self.readers
            ],
            straightened=[view.lens != PINHOLE for view in self.views],
            depth=self.depth,
            mesh=self.mesh,
        )


def _mesh_size(mesh: Path) -> int:
    try:
        return mesh.stat().st_size
    except OSError as error:
        raise InputError(mesh, f"cannot be read ({error.strerror})", "give a mesh as PLY, OBJ or GLB") from error


def _said_of(downscale: int, reductions: Mapping[str, int]) -> list[str]:
    """Return a fingerprint's part on reduced pictures, empty without reduction."""
    whole = [] if downscale == 1 else [str(downscale)]
    return whole + [f"{name}={factor}" for name, factor in sorted(reductions.items())]


class _Source:
    """The pictures and masks of a recording at the size that is asked for, by the common clock."""

    def __init__(self, recording: Recording, masks: MaskFiles, shown: Sequence[Camera]) -> None:
        self._recording = recording
        self._masks = masks
        self._shown = shown
        self._ticks = [{int(own): tick for tick, own in enumerate(row)} for row in recording.clock.frames]

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], Iterable[Neighbour]]:
        own, ticks = int(self._recording.clock.frames[camera, frame]), self._ticks[camera]
        picture, passed = self._recording.readers[camera].read(own, neighbours)
        others = [(ticks[index], self._seen(camera, other)) for index, other in passed if index in ticks]
        return self._seen(camera, picture), others

    def read_lines(self, camera: int, frame: int) -> npt.NDArray[np.uint8]:
        own, reader = int(self._recording.clock.frames[camera, frame]), self._recording.readers[camera]
        if isinstance(reader, VideoReader):
            return reader.lines(own)
        picture, _ = reader.read(own, 0)
        return picture[..., 1]

    def read_mask(self, camera: int, frame: int) -> npt.NDArray[np.bool_] | None:
        view = self._recording.views[camera]
        mask = self._masks.read(view, int(self._recording.clock.frames[camera, frame]))
        return None if mask is None else reduced_mask(mask, self._shown[camera])

    def mask_file(self, camera: int, frame: int) -> Path | None:
        return self._masks.file(self._recording.views[camera], int(self._recording.clock.frames[camera, frame]))

    def _seen(self, camera: int, picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        return reduced_picture(self._recording.views[camera].straightened(picture), self._shown[camera])
