"""Pictures and masks in image files, read with every check that a loader needs."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, UnidentifiedImageError

from hgs_core.base.errors import InputError
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
    return _pixels(path, (camera.width, camera.height), "RGB", f"camera {camera.name} needs")


def read_sized_picture(path: Path, size: tuple[int, int]) -> npt.NDArray[np.uint8]:
    """Return the picture [H, W, 3] of `size` (width, height).

    Raises:
        InputError: the file is missing, unreadable, or of another size.
    """
    return _pixels(path, size, "RGB", "it was")


def read_mask(path: Path, camera: Camera) -> npt.NDArray[np.bool_]:
    """Return the mask [H, W]; every value above 0 is True, in a JPEG, which keeps no value exactly, from 128.

    Raises:
        InputError: the file is missing, unreadable, or not of the camera's size.
    """
    values = _levels(_pixels(path, (camera.width, camera.height), None, f"camera {camera.name} needs"))
    return np.asarray(values >= 128 if _is_jpeg(path) else values > 0, bool)


def mask_levels(path: Path) -> npt.NDArray[np.uint8]:
    """Return the levels [H, W] of a mask as they are stored.

    Raises:
        InputError: the file is missing or unreadable.
    """
    return _levels(_pixels(path, picture_size(path), None, "it was"))


def check_size(path: Path, camera: Camera) -> None:
    """Read the header alone.

    Raises:
        InputError: as `read_picture`, as far as the header tells.
    """
    _check_size(path, picture_size(path), (camera.width, camera.height), f"camera {camera.name} needs")


def picture_size(path: Path) -> tuple[int, int]:
    """Return width and height in pixels, from the header.

    Raises:
        InputError: the file is missing or unreadable.
    """
    try:
        with Image.open(path) as image:
            return image.size
    except (OSError, UnidentifiedImageError) as error:
        raise _unreadable(path, error) from error


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
    """Return the names and sizes in bytes of the files in a folder; of none if the folder does not exist.

    Raises:
        InputError: the folder may not be read, or a link in it leads to itself.
    """
    return {entry.name: entry.stat().st_size for entry in _entries(folder) if _safely(entry, entry.is_file)}


def list_folders(folder: Path) -> list[str]:
    """Return the names of the folders in a folder, sorted, hidden ones left out; of none if it does not exist.

    Raises:
        InputError: the folder may not be read, or a link in it leads to itself.
    """
    return sorted(e.name for e in _entries(folder) if not e.name.startswith(".") and _safely(e, e.is_dir))


def numbered_pictures(folder: Path) -> dict[int, Path]:
    """Return the files `<number>.png` of a folder by their numbers, which may have leading zeros."""
    return {int(Path(name).stem): folder / name for name in list_folder(folder) if _NUMBERED.fullmatch(name)}


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            return list(entries)
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


def _pixels(path: Path, size: tuple[int, int], mode: str | None, wanted: str) -> npt.NDArray[np.uint8]:
    """Return the pixels in Pillow's `mode`, or as they are stored."""
    try:
        with Image.open(path) as image:
            _check_size(path, image.size, size, wanted)
            if mode == "RGB" and image.mode == "F":
                problem = "the picture has floating-point values, whose white nothing states"
                raise InputError(path, problem, "store 8 or 16 bits per channel")
            if mode == "RGB" and image.mode.startswith("I"):  # 16 bits of grey, which Pillow would cut off at 255
                levels = (np.asarray(image).clip(0, 65535) / 257 + 0.5).astype(np.uint8)
                return np.repeat(levels[..., None], 3, axis=2)
            return np.array(image.convert(mode) if mode else image)
    except (OSError, UnidentifiedImageError, SyntaxError) as error:
        raise _unreadable(path, error) from error


def _check_size(path: Path, size: tuple[int, int], right: tuple[int, int], wanted: str) -> None:
    if size != right:
        raise InputError(path, f"the picture is {size[0]}x{size[1]}", f"{wanted} {right[0]}x{right[1]}")


def _unreadable(path: Path, error: Exception) -> InputError:
    if isinstance(error, FileNotFoundError):
        return InputError(path, "the picture is missing", "restore the file")
    if isinstance(error, PermissionError):
        return InputError(path, "the picture may not be read", "make it readable")
    return InputError(path, f"the picture is unreadable ({error})", "restore the file from its source")
