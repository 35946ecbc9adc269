"""COLMAP's files of cameras and images, binary and text, without the points, which are most of their bytes."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.cameras.rig import LARGEST, MOST_CAMERAS
from hgs_core.capture.files.text_file import text_lines
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.lenses.colmap_lens import COLMAP_MODELS

__all__ = ["ColmapCamera", "ColmapImage", "model_files", "read_model"]

_CURE = "export the model again"
_BY_NUMBER = {number: (name, len(parameters.split())) for name, (number, parameters) in COLMAP_MODELS.items()}
_POINT_BYTES = 24  # one point in images.bin
_LONGEST_IMAGE_LINE = 1 << 13  # characters, name and all; lines of points are far longer
_LARGEST_SIDE = 10**9  # pixels
_LONGEST_NAME = 4096  # bytes


@dataclass(frozen=True)
class ColmapCamera:
    """The lens of some images."""

    model: str
    width: int
    height: int
    parameters: tuple[float, ...]


@dataclass(frozen=True)
class ColmapImage:
    """The pose of an image."""

    name: str
    camera: int
    world_to_camera: npt.NDArray[np.float64]  # [4, 4]


def model_files(folder: Path) -> tuple[Path, Path] | None:
    """Return the files of cameras and of images in a folder, binary ones first; None if there are none."""
    for ending in (".bin", ".txt"):
        cameras, images = folder / f"cameras{ending}", folder / f"images{ending}"
        if cameras.is_file() and images.is_file():
            return cameras, images
    return None


def read_model(cameras: Path, images: Path) -> tuple[dict[int, ColmapCamera], list[ColmapImage]]:
    """Return the cameras by their numbers, and the images in the order of their names.

    Raises:
        InputError: a file is unreadable or damaged.
    """
    read = (_binary_cameras, _binary_images) if cameras.suffix == ".bin" else (_text_cameras, _text_images)
    found = _checked(cameras, read[0])
    poses = _checked(images, read[1])
    for image in poses:
        if image.camera not in found:
            problem = f"image {image.name} is of camera {image.camera}, which {cameras.name} lacks"
            raise InputError(images, problem, _CURE)
    if not poses:
        raise InputError(images, "lists no image", "export a model with its images")
    return found, sorted(poses, key=lambda image: image.name)


def _checked(file: Path, read):  # type: ignore[no-untyped-def]
    try:
        return read(file)
    except (OSError, struct.error, ValueError, IndexError, KeyError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise unreadable(file, error, _CURE) from error


def _binary_cameras(file: Path) -> dict[int, ColmapCamera]:
    found: dict[int, ColmapCamera] = {}
    with file.open("rb") as opened:
        for _ in range(_count(opened)):
            number, model, width, height = _take(opened, "<iiQQ")
            if model not in _BY_NUMBER:
                raise InputError(file, f"camera {number} is of the unknown model {model}", "export it as OPENCV")
            name, parameters = _BY_NUMBER[model]
            _require_new(file, number, found)
            found[number] = ColmapCamera(name, width, height, _take(opened, f"<{parameters}d"))
    return found


def _binary_images(file: Path) -> list[ColmapImage]:
    found, size = [], file.stat().st_size
    with file.open("rb") as opened:
        for _ in range(_count(opened)):
            values = _take(opened, "<I7dI")
            name = bytearray()
            while (letter := opened.read(1)) != b"\0":
                if not letter or len(name) > _LONGEST_NAME:
                    raise ValueError("it ends inside the name of an image")
                name += letter
            (points,) = _take(opened, "<Q")
            if points * _POINT_BYTES > size - opened.tell():
                raise ValueError("it ends inside the points of an image")
            opened.seek(points * _POINT_BYTES, 1)
            found.append(ColmapImage(name.decode("utf-8"), values[8], _pose(file, values[1:5], values[5:8])))
    return found


def _count(opened: BinaryIO) -> int:
    (count,) = _take(opened, "<Q")
    if count > MOST_CAMERAS:
        raise ValueError(f"it announces {count} records")
    return int(count)


def _take(opened: BinaryIO, layout: str) -> tuple:  # type: ignore[type-arg]
    return struct.unpack(layout, opened.read(struct.calcsize(layout)))


def _text_cameras(file: Path) -> dict[int, ColmapCamera]:
    found: dict[int, ColmapCamera] = {}
    for line in text_lines(file, _CURE):
        words = line.split()
        if words and not words[0].startswith("#"):
            parameters = tuple(float(word) for word in words[4:])
            _require_new(file, int(words[0]), found)
            if max(int(words[2]), int(words[3])) > _LARGEST_SIDE:
                raise ValueError(f"camera {words[0]} has pictures of {words[2]}x{words[3]} pixels")
            found[int(words[0])] = ColmapCamera(words[1], int(words[2]), int(words[3]), parameters)
    return found


def _text_images(file: Path) -> list[ColmapImage]:
    """Read the lines of images, each followed by one of its points, which some tools leave out or leave empty."""
    found: list[ColmapImage] = []
    of_points = False  # whether the line may be of the points of the image before
    for line in text_lines(file, _CURE):
        if line.startswith("#") or (not of_points and not line.strip()):
            continue
        if of_points and _are_points(line):
            of_points = False
            continue
        words = line.split(maxsplit=9)
        if len(words) < 10:
            raise ValueError(f"a line of an image has {len(words)} words, not 10")
        pose = _pose(file, [float(word) for word in words[1:5]], [float(word) for word in words[5:8]])
        found.append(ColmapImage(words[9].strip(), int(words[8]), pose))
        if len(found) > MOST_CAMERAS:
            raise ValueError(f"it has more than {MOST_CAMERAS} images")
        of_points = True
    return found


def _are_points(line: str) -> bool:
    """Whether a line holds X, Y, POINT3D_ID of points, perhaps of none: numbers by three, and no image's name."""
    if len(line) > _LONGEST_IMAGE_LINE:
        return True
    words = line.split()
    return len(words) % 3 == 0 and all(_is_number(word) for word in words)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _require_new(file: Path, number: int, found: dict[int, ColmapCamera]) -> None:
    if number in found:
        raise InputError(file, f"camera {number} is there twice", _CURE)


def _pose(
    file: Path, quaternion: tuple[float, ...] | list[float], translation: tuple[float, ...] | list[float]
) -> npt.NDArray[np.float64]:
    q = np.array(quaternion, np.float64)
    place = np.array(translation, np.float64)
    if len(q) != 4 or not np.isfinite(q).all() or not q.any() or len(place) != 3 or not (np.abs(place) < LARGEST).all():
        raise InputError(file, f"a pose is {shown([*quaternion, *translation])}", "estimate the cameras again")
    q = q / np.abs(q).max()  # keeps squares finite
    w, x, y, z = q / np.linalg.norm(q)
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = place
    return pose
