"""Pictures and masks in image files, read with every check that a loader needs."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.picture_file import read_header, read_pixels
from hgs_core.scene.camera import Camera

__all__ = [
    "check_size",
    "list_folder",
    "list_folders",
    "mask_levels",
    "numbered_pictures",
    "picture_size",
    "read_mask",
    "read_picture",
    "read_sized_picture",
    "reduced_mask",
    "reduced_picture",
]

_NUMBERED = re.compile(r"\d+\.png")


def read_picture(path: Path, camera: Camera) -> npt.NDArray[np.uint8]:
    """Return the picture [H, W, 3].

    Raises:
        InputError: the file is missing, unreadable, or not of the camera's size.
    """
    return _pixels(path, (camera.width, camera.height), f"camera {camera.name} needs")


def read_sized_picture(path: Path, size: tuple[int, int], *, upright: bool = False) -> npt.NDArray[np.uint8]:
    """Return the picture [H, W, 3] of `size` (width, height), as it is stored, or `upright` as EXIF says.

    Raises:
        InputError: the file is missing, unreadable, or of another size.
    """
    return _pixels(path, size, "it was", upright=upright)


def read_mask(path: Path, camera: Camera) -> npt.NDArray[np.bool_]:
    """Return the mask [H, W]; every value above 0 is True, in a JPEG, which keeps no value exactly, from 128.

    Raises:
        InputError: the file is missing, unreadable, or not of the camera's size.
    """
    values = _levels(_pixels(path, (camera.width, camera.height), f"camera {camera.name} needs", colours=False))
    return np.asarray(values >= 128 if _is_jpeg(path) else values > 0, bool)


def mask_levels(path: Path) -> npt.NDArray[np.uint8]:
    """Return the levels [H, W] of a mask as they are stored.

    Raises:
        InputError: the file is missing or unreadable.
    """
    return _levels(read_pixels(path, colours=False))


def check_size(path: Path, camera: Camera) -> None:
    """Read the header alone.

    Raises:
        InputError: as `read_picture`, as far as the header tells.
    """
    _check_size(path, picture_size(path), (camera.width, camera.height), f"camera {camera.name} needs")


def picture_size(path: Path) -> tuple[int, int]:
    """Return width and height as stored in pixels, from the header.

    Raises:
        InputError: the file is missing or unreadable.
    """
    return read_header(path).size


def reduced_picture(picture: npt.NDArray[np.uint8], size: Camera) -> npt.NDArray[np.uint8]:
    """Return a picture [H, W, 3] averaged over the areas of the pixels of the camera `size`."""
    if picture.shape[:2] == (size.height, size.width):
        return picture
    return np.array(Image.fromarray(picture).resize((size.width, size.height), Image.Resampling.BOX))


def reduced_mask(mask: npt.NDArray[np.bool_], size: Camera) -> npt.NDArray[np.bool_]:
    """Return a mask [H, W] at the size of the camera `size`: a pixel is set if any part of it is."""
    if mask.shape == (size.height, size.width):
        return mask
    shares = Image.fromarray(mask.astype(np.float32)).resize((size.width, size.height), Image.Resampling.BOX)
    return np.asarray(np.array(shares) > 0, bool)


def list_folder(folder: Path) -> dict[str, int]:
    """Return the names and sizes in bytes of the files in a folder, hidden ones left out; of none if it does not exist.

    Raises:
        InputError: the folder may not be read, or a link in it leads to itself.
    """
    return {e.name: e.stat().st_size for e in _entries(folder) if _safely(e, e.is_file)}


def list_folders(folder: Path) -> list[str]:
    """Return the names of the folders in a folder, sorted, hidden ones left out; of none if it does not exist.

    Raises:
        InputError: the folder may not be read, or a link in it leads to itself.
    """
    return sorted(e.name for e in _entries(folder) if _safely(e, e.is_dir))


def numbered_pictures(folder: Path) -> dict[int, Path]:
    """Return the files `<number>.png` of a folder by their numbers, which may have leading zeros."""
    return {int(Path(name).stem): folder / name for name in list_folder(folder) if _NUMBERED.fullmatch(name)}


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            # macOS leaves files such as ._0001.png beside its copies.
            return [entry for entry in entries if not entry.name.startswith(".")]
    except (FileNotFoundError, NotADirectoryError):
        return []
    except OSError as error:
        raise InputError(folder, f"cannot be read ({error.strerror})", "make the folder readable") from error


def _safely(entry: os.DirEntry[str], kind: Callable[[], bool]) -> bool:
    try:
        return kind()
    except OSError as error:
        raise InputError(entry.path, f"cannot be read ({error.strerror})", "make it readable, or remove it") from error


def _levels(values: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return the largest colour of each pixel; a second or fourth channel is transparency."""
    return values if values.ndim == 2 else values[:, :, : values.shape[2] - (values.shape[2] % 2 == 0)].max(axis=2)


def _is_jpeg(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(3) == b"\xff\xd8\xff"


def _pixels(
    path: Path, size: tuple[int, int], wanted: str, *, upright: bool = False, colours: bool = True
) -> npt.NDArray[np.uint8]:
    header = read_header(path)
    _check_size(path, header.upright if upright else header.size, size, wanted)
    return read_pixels(path, upright=upright, colours=colours)


def _check_size(path: Path, size: tuple[int, int], right: tuple[int, int], wanted: str) -> None:
    if size != right:
        raise InputError(path, f"the picture is {size[0]}x{size[1]}", f"{wanted} {right[0]}x{right[1]}")
