"""Given depth maps: one of a camera, `<camera>.png`, or one per frame, `<camera>/<FFFF>.png`; EXR in place of PNG.

The map of a camera shows the still scene; maps of frames show their moments (docs/captures.md).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.lenses.straighten import StraightView
from hgs_core.capture.pictures.depth_scale import DEPTH_FILE, DepthScale, Measured, read_depth_scale
from hgs_core.capture.pictures.exr_file import read_exr, read_exr_header
from hgs_core.capture.pictures.picture import list_folder, picture_size
from hgs_core.capture.pictures.picture_file import read_pixels
from hgs_core.scene.camera import Camera

__all__ = ["DepthFiles", "find_depth"]

_SUFFIXES = (".exr", ".png")  # the last counts where there are several of one name
_MOST_BITS = 16

Depths = npt.NDArray[np.float32]


@dataclass(frozen=True)
class DepthFiles:
    """The depth maps of some cameras, by the cameras' places in the capture."""

    scale: DepthScale
    views: Sequence[StraightView]  # one for each camera of the capture
    still: Mapping[int, Path]  # maps of whole cameras
    moments: Mapping[int, Mapping[int, Path]]  # maps by the capture's frames

    def files(self) -> list[tuple[Path, int]]:
        """Return the maps and their sizes in bytes."""
        paths = [*self.still.values(), *(path for own in self.moments.values() for path in own.values())]
        return [(path, path.stat().st_size) for path in paths]

    @property
    def cameras(self) -> list[int]:
        """The cameras that have a map, ascending."""
        return sorted({*self.still, *self.moments})

    def frames(self, camera: int) -> Sequence[int]:
        """Return the frames of which a camera has maps, ascending."""
        return sorted(self.moments.get(camera, ()))

    def still_depth(self, camera: int, size: Camera) -> Depths | None:
        """Return the depths [H, W] along the axis of a camera at the `size` of a picture; 0 where they are unknown.

        None where there is no map of the whole camera.

        Raises:
            InputError: the map is unreadable.
        """
        path = self.still.get(camera)
        return None if path is None else self._read(path, camera, size)

    def depth(self, camera: int, frame: int, size: Camera) -> Depths | None:
        """Return the same of one frame; None where there is no map of it.

        Raises:
            InputError: the map is unreadable.
        """
        path = self.moments.get(camera, {}).get(frame)
        return None if path is None else self._read(path, camera, size)

    def notes(self, names: Sequence[str]) -> list[str]:
        """Say for which of the cameras depth is given."""
        given = ", ".join(names[camera] for camera in self.cameras)
        return [f"depth of {given} is given, in {self.scale.file.parent}"]

    def _read(self, path: Path, camera: int, size: Camera) -> Depths:
        """Take the nearest value of every pixel's centre: a mean of two surfaces lies on neither."""
        view, stored = self.views[camera], self.scale.distances(_values(path))
        down, across = np.mgrid[0 : size.height, 0 : size.width] + 0.5
        x, y = (across - size.cx) / size.fx, (down - size.cy) / size.fy
        bent = view.bent
        if stored.shape == (view.camera.height, view.camera.width):  # a map of the straight picture
            bent, (u, v) = view.camera, (x, y)
        else:
            u, v = (np.asarray(one) for one in view.lens.apply(x, y))
        column = np.floor((u * bent.fx + bent.cx) * (stored.shape[1] / bent.width)).astype(np.int64)
        row = np.floor((v * bent.fy + bent.cy) * (stored.shape[0] / bent.height)).astype(np.int64)
        depths: Depths = stored[row.clip(0, stored.shape[0] - 1), column.clip(0, stored.shape[1] - 1)]
        if self.scale.measured is Measured.RAY:
            depths = (depths / np.sqrt(x * x + y * y + 1)).astype(np.float32)
        return depths


def find_depth(
    folder: Path,
    views: Sequence[StraightView],
    others: Sequence[str],  # the cameras' names in the footage
    pictures: Sequence[Sequence[str] | None],  # the names of the cameras' pictures, without endings; None: of a video
    frames: Sequence[Sequence[int]],  # frames of each camera that are in use, by the capture's frame
    numbers: Sequence[Sequence[int]] | None,  # numbers of each camera's pictures; None: videos
) -> DepthFiles:
    """Return the depth maps in a folder; cameras and frames may lack theirs.

    A map of a frame is called like its picture or by its number, or else by its place in the footage, from 0. It may be
    larger or smaller than the picture, but of its shape.

    Raises:
        InputError: there is no depth.json or no map, a map is unreadable, of another shape, or of no frame.
    """
    if not folder.is_dir():
        raise InputError(folder, "the folder of depth maps does not exist", "give the folder that has depth.json")
    scale = read_depth_scale(folder)
    there = _by_stem(folder)
    still: dict[int, Path] = {}
    moments: dict[int, dict[int, Path]] = {}
    for index, (view, other) in enumerate(zip(views, others, strict=True)):
        for name in dict.fromkeys((view.camera.name, other)):
            if index not in still and name in there:
                still[index] = there[name]
            if index not in moments and (folder / name).is_dir():
                own = None if numbers is None else numbers[index]
                moments[index] = _of_frames(folder / name, pictures[index], frames[index], own)
    found = DepthFiles(scale, views, still, moments)
    for index in found.cameras:
        for path in (*([still[index]] if index in still else []), *moments.get(index, {}).values()):
            _require_shape(path, views[index])
    if not found.cameras:
        listed = ", ".join(view.camera.name for view in views)
        raise InputError(folder, "holds no depth map of this capture", f"call maps like the cameras {listed}")
    return dataclasses.replace(found, moments={index: own for index, own in moments.items() if own})


def _by_stem(folder: Path) -> dict[str, Path]:
    """Return the maps of a folder by their names without endings."""
    names = [name for name in list_folder(folder) if name.lower().endswith(_SUFFIXES)]
    names.sort(key=lambda name: _SUFFIXES.index(Path(name).suffix.lower()))
    return {Path(name).stem: folder / name for name in names}


def _of_frames(
    folder: Path, names: Sequence[str] | None, used: Sequence[int], numbers: Sequence[int] | None
) -> dict[int, Path]:
    """Return the maps of a camera's folder by the capture's frames."""
    there = _by_stem(folder)
    if names is not None and (found := {t: there[names[own]] for t, own in enumerate(used) if names[own] in there}):
        return found
    numbered = {int(stem): path for stem, path in there.items() if stem.isdecimal()}
    called = range(max(used) + 1) if numbers is None or not numbered.keys() <= set(numbers) else numbers
    found = {tick: numbered[called[own]] for tick, own in enumerate(used) if called[own] in numbered}
    if there and not found:
        cure = "call maps like the pictures or number them from 0"
        raise InputError(folder, f"its {len(there)} depth maps are of none of the frames in use", cure)
    return found


def _require_shape(path: Path, view: StraightView) -> None:
    width, height = read_exr_header(path).size if path.suffix.lower() == ".exr" else picture_size(path)
    for camera in (view.bent, view.camera):
        if abs(width * camera.height - height * camera.width) <= 2 * max(camera.height, camera.width, width, height):
            return
    problem = f"the depth map is {width}x{height}; the pictures of {view.camera.name} are of another shape"
    raise InputError(path, problem, f"make it {view.bent.width}x{view.bent.height}, or a part of that on both sides")


def _values(path: Path) -> npt.NDArray[np.float32] | npt.NDArray[np.float64]:
    """Return the values [H, W] of a map as they are stored."""
    if path.suffix.lower() == ".exr":
        return read_exr(path)
    values = read_pixels(path, colours=False)
    if values.ndim != 2 or values.dtype.itemsize * 8 < _MOST_BITS:
        what = "colours" if values.ndim != 2 else f"{values.dtype.itemsize * 8} bits per pixel"
        cure = f"write one channel of 16 bits, and the length of a step into {DEPTH_FILE}"
        raise InputError(path, f"the depth map has {what}, too coarse for depths", cure)
    return values.astype(np.float64)
