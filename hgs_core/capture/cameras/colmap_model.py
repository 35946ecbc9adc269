"""COLMAP's files of cameras and images, binary and text, without the points, which are most of their bytes."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.colmap_lens import COLMAP_MODELS
from hgs_core.capture.unreadable import unreadable

__all__ = ["ColmapCamera", "ColmapImage", "model_files", "read_model"]

_BY_NUMBER = {number: (name, len(parameters.split())) for name, (number, parameters) in COLMAP_MODELS.items()}
_POINT_BYTES = 24  # of a point in images.bin
_MOST_RECORDS = 10_000_000  # a damaged count must not be believed
_LONGEST_NAME = 4096


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
            raise InputError(images, problem, "export the model again")
    if not poses:
        raise InputError(images, "lists no image", "export a model with its images")
    return found, sorted(poses, key=lambda image: image.name)


def _checked(file: Path, read):  # type: ignore[no-untyped-def]
    try:
        return read(file)
    except (OSError, struct.error, ValueError, IndexError, KeyError, OverflowError) as error:
        if isinstance(error, InputError):
            raise
        raise unreadable(file, error, "export the model again") from error


def _binary_cameras(file: Path) -> dict[int, ColmapCamera]:
    found = {}
    with file.open("rb") as opened:
        for _ in range(_count(opened)):
            number, model, width, height = _take(opened, "<iiQQ")
            if model not in _BY_NUMBER:
                raise InputError(file, f"camera {number} is of the unknown model {model}", "export it as OPENCV")
            name, parameters = _BY_NUMBER[model]
            found[number] = ColmapCamera(name, width, height, _take(opened, f"<{parameters}d"))
    return found


def _binary_images(file: Path) -> list[ColmapImage]:
    found = []
    with file.open("rb") as opened:
        for _ in range(_count(opened)):
            values = _take(opened, "<I7dI")
            name = bytearray()
            while (letter := opened.read(1)) != b"\0":
                if not letter or len(name) > _LONGEST_NAME:
                    raise ValueError("it ends inside the name of an image")
                name += letter
            (points,) = _take(opened, "<Q")
            opened.seek(points * _POINT_BYTES, 1)
            found.append(ColmapImage(name.decode("utf-8"), values[8], _pose(file, values[1:5], values[5:8])))
        size = file.stat().st_size
        if opened.tell() > size:
            raise ValueError("it ends inside the points of an image")
    return found


def _count(opened: BinaryIO) -> int:
    (count,) = _take(opened, "<Q")
    if count > _MOST_RECORDS:
        raise ValueError(f"it announces {count} records")
    return int(count)


def _take(opened: BinaryIO, layout: str) -> tuple:  # type: ignore[type-arg]
    return struct.unpack(layout, opened.read(struct.calcsize(layout)))


def _text_cameras(file: Path) -> dict[int, ColmapCamera]:
    found = {}
    for line in file.read_text("utf-8").splitlines():
        words = line.split()
        if words and not line.startswith("#"):
            parameters = tuple(float(word) for word in words[4:])
            found[int(words[0])] = ColmapCamera(words[1], int(words[2]), int(words[3]), parameters)
    return found


def _text_images(file: Path) -> list[ColmapImage]:
    lines = [line for line in file.read_text("utf-8").splitlines() if not line.startswith("#")]
    while lines and not lines[0].strip():
        lines.pop(0)
    found = []
    for line in lines[::2]:  # every second line is of the image's points
        words = line.split(maxsplit=9)
        if words:
            pose = _pose(file, [float(word) for word in words[1:5]], [float(word) for word in words[5:8]])
            found.append(ColmapImage(words[9].strip(), int(words[8]), pose))
    return found


def _pose(
    file: Path, quaternion: tuple[float, ...] | list[float], translation: tuple[float, ...] | list[float]
) -> npt.NDArray[np.float64]:
    q = np.array(quaternion, np.float64)
    norm = float(np.linalg.norm(q))
    if not np.isfinite(norm) or norm == 0 or not np.isfinite(translation).all():
        raise InputError(file, f"a pose is {[*quaternion, *translation]}", "estimate the cameras again")
    w, x, y, z = q / norm
    pose = np.eye(4)
    pose[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    pose[:3, 3] = translation
    return pose
