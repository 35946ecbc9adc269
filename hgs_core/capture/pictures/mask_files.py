"""Given motion masks: one PNG per camera and frame, `<camera>/<FFFF>.png`, where any value above 0 moves.

This is what segmentation tools such as SAM 2 or Track Anything write: 0 and 255, or the number of an object, as grey
values or palette entries (docs/captures.md). In JPEG files, which keep no number exactly, 128 and above moves.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.footage import is_picture
from hgs_core.capture.lenses.straighten import StraightView
from hgs_core.capture.pictures.picture import list_folder, picture_size, read_mask

__all__ = ["MaskFiles", "find_masks"]


_SUFFIXES = (".jpeg", ".jpg", ".png")  # the last counts where there are several of one name


@dataclass(frozen=True)
class MaskFiles:
    """The mask files of some cameras, one per frame."""

    files: Mapping[str, Mapping[int, Path]]  # camera name -> frame number -> file
    folder: Path | None = None  # place, shown to people

    def read(self, view: StraightView, frame: int) -> npt.NDArray[np.bool_] | None:
        """Return the mask [H, W] of a frame's straight picture, or None if none are given for the camera.

        Raises:
            InputError: the file is missing, unreadable, or not of the camera's size.
        """
        files = self.files.get(view.camera.name)
        if files is None:
            return None
        path = files[frame]
        if picture_size(path) == (view.camera.width, view.camera.height):  # the size that `hgs masks` writes
            return read_mask(path, view.camera)
        return view.straight_mask(read_mask(path, view.bent))

    def file(self, view: StraightView, frame: int) -> Path | None:
        """Return the file of a frame's mask, or None if none are given for the camera."""
        files = self.files.get(view.camera.name)
        return None if files is None else files[frame]

    def sizes(self) -> list[tuple[Path, int]]:
        """Return the files and their sizes in bytes."""
        return [(path, path.stat().st_size) for files in self.files.values() for path in files.values()]

    def notes(self, cameras: Sequence[str]) -> list[str]:
        """Say for which of the cameras masks are given, unless for none."""
        if not self.files:
            return []
        rest = [name for name in cameras if name not in self.files]
        given = f"the masks of {', '.join(self.files)} are given, in {self.folder}"
        return [f"{given}; those of {', '.join(rest)} are computed" if rest else given]


def find_masks(
    folders: Sequence[Path],
    views: Sequence[StraightView],
    others: Sequence[str],  # the cameras' names in the footage
    pictures: Sequence[Sequence[str] | None],  # the names of the cameras' pictures, without endings; None: of a video
    frames: Sequence[Sequence[int]],  # frames of each camera that need masks
    *,
    numbers: Sequence[Sequence[int]] | None = None,  # numbers of each camera's pictures; None: videos
    required: bool = False,
) -> MaskFiles:
    """Return the masks in the first of the folders that has some, one folder per camera; the others' are not given.

    A mask is called like its picture or by its number, or else by its place in the footage, from 0. It has the size of
    the picture on disk, or of the straight one.

    Raises:
        InputError: a camera's folder lacks a frame, or one of its masks is unreadable or not of the camera's size; or,
            if masks are `required`, there is no folder of any camera.
    """
    for folder in folders:
        found = {}
        for index, (view, other) in enumerate(zip(views, others, strict=True)):
            own = next((folder / name for name in (view.camera.name, other) if (folder / name).is_dir()), None)
            if own is not None:
                of_pictures = None if numbers is None else numbers[index]
                found[view.camera.name] = _files(own, view, pictures[index], frames[index], of_pictures)
        if found:
            return MaskFiles(found, folder)
    if required:
        folder = folders[0]
        problem = "holds no masks of this capture" if folder.is_dir() else "the folder does not exist"
        listed = ", ".join(view.camera.name for view in views)
        raise InputError(folder, problem, f"it has one folder of PNG files for each camera of {listed}")
    return MaskFiles({})


def _files(
    folder: Path,
    view: StraightView,
    names: Sequence[str] | None,
    needed: Sequence[int],
    numbers: Sequence[int] | None,
) -> dict[int, Path]:
    files = [name for name in list_folder(folder) if name.lower().endswith(_SUFFIXES)]
    files.sort(key=lambda name: _SUFFIXES.index(Path(name).suffix.lower()))
    there = {_picture_of(name): folder / name for name in files}
    if names is not None and all(names[frame] in there for frame in needed):
        found = {frame: there[names[frame]] for frame in needed}
    else:
        masks = {int(stem): path for stem, path in there.items() if stem.isdecimal()}
        called = _called(masks, needed, numbers)
        for frame in needed:
            if called[frame] not in masks:
                cure = "call masks like the pictures or number them from 0, or remove the folder to have them computed"
                raise InputError(folder, f"the mask of frame {called[frame]} is missing", cure)
        found = {frame: masks[called[frame]] for frame in needed}
    straight = (view.camera.width, view.camera.height)
    for path in found.values():
        size, right = picture_size(path), (view.bent.width, view.bent.height)
        if size not in (straight, right):
            problem = f"the mask is {size[0]}x{size[1]}; camera {view.camera.name} needs {right[0]}x{right[1]}"
            every = f"{shlex.quote(str(folder))}/*{path.suffix}"
            resize = f"mogrify -filter point -resize '{right[0]}x{right[1]}!' {every} (ImageMagick)"
            raise InputError(path, problem, resize if _alike(size, right) else "make masks of these pictures")
    return found


def _picture_of(name: str) -> str:
    """Return the name of a mask's picture without an ending: COLMAP calls the mask of a.jpg a.jpg.png."""
    stem = Path(name).stem
    return Path(stem).stem if is_picture(stem) else stem


def _alike(size: tuple[int, int], other: tuple[int, int]) -> bool:
    """Return whether two sizes have the same shape, within two pixels."""
    return abs(size[0] * other[1] - size[1] * other[0]) <= 2 * max(size[1], other[1])


def _called(masks: Mapping[int, Path], needed: Sequence[int], numbers: Sequence[int] | None) -> Sequence[int]:
    """Return by which numbers masks are called, of each of the camera's pictures: by theirs, or by their places."""
    places = range(max(needed) + 1)
    if numbers is None:
        return places
    # All of the camera's pictures tell more surely than those in use which of the two it is.
    for used in (range(len(numbers)), needed):
        if all(numbers[place] in masks for place in used):
            return numbers
        if all(place in masks for place in used):
            return places
    return numbers
