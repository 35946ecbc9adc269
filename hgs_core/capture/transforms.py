"""Photographs of a still scene in the layout of instant-ngp and nerfstudio: transforms.json and the pictures it names.

`transforms.json` holds the intrinsics `fl_x`, `fl_y`, `cx`, `cy`, `w`, `h` and the distortion `k1`...`k4`, `p1`, `p2`
(`hgs_core/capture/distortion.py`), for all pictures or in a frame of their own, and per frame the picture `file_path`
and `transform_matrix` [4, 4], which is camera-to-world in the convention of OpenGL: x right, y up, z backwards.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.cache import Neighbour
from hgs_core.capture.distortion import Distortion, straight_camera, straightened
from hgs_core.capture.layout import Layout, Outline
from hgs_core.capture.mask_files import find_masks
from hgs_core.capture.picture import picture_size, read_picture
from hgs_core.capture.recording import Recording
from hgs_core.scene.camera import Camera

__all__ = ["NERFSTUDIO", "TRANSFORMS_FILE", "camera_from_transform", "load_transforms"]

TRANSFORMS_FILE = "transforms.json"
_LENSES = ("", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV")
_COEFFICIENTS = ("k1", "k2", "k3", "k4", "p1", "p2")
_MOST_NAMED = 5  # pictures that a note names


class _Photographs:
    """One picture per camera, straightened when it is read."""

    def __init__(self, files: list[Path], bent: list[Camera], lenses: list[Distortion], straight: list[Camera]) -> None:
        self._files = files
        self._bent = bent
        self._lenses = lenses
        self._straight = straight

    def read(self, camera: int, frame: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], tuple[Neighbour, ...]]:
        picture = read_picture(self._files[camera], self._bent[camera])
        return straightened(picture, self._bent[camera], self._lenses[camera], self._straight[camera]), ()


def load_transforms(path: Path, masks: Path | None) -> Recording:
    """Read a capture in this layout; frames whose picture is not there are left out with a note.

    Raises:
        InputError: transforms.json is unreadable or inconsistent, a lens is of an unknown kind, frames have moments of
            their own, or no picture is there.
    """
    where = path / TRANSFORMS_FILE
    meta = _read_meta(where)
    frames = meta["frames"]
    _require_one_moment(where, frames)
    files = [path / _picture_name(where, number, frame) for number, frame in enumerate(frames)]
    there = [number for number, file in enumerate(files) if file.is_file()]
    missing = [file.name for file in files if not file.is_file()]
    if not there:
        raise InputError(where, f"none of its {len(frames)} pictures is there", "restore the pictures")
    names = _camera_names(path, [files[number] for number in there])
    bent, lenses = [], []
    for number, name in zip(there, names, strict=True):
        values = {**meta, **frames[number]}
        bent.append(camera_from_transform(name, picture_size(files[number]), values, f"{where}, frame {number}"))
        lenses.append(Distortion(**{key: _number(values, key, f"{where}, {key}", 0.0) for key in _COEFFICIENTS}))
    straight = [straight_camera(camera, lens) for camera, lens in zip(bent, lenses, strict=True)]
    pictures = [files[number] for number in there]
    return Recording(
        path,
        straight,
        np.zeros(1),
        _Photographs(pictures, bent, lenses, straight),
        find_masks(masks or path / "masks", bent, 1, required=masks is not None),
        [(file, file.stat().st_size) for file in pictures],
        where,
        (_missing_note(missing, len(files)),) if missing else (),
    )


def camera_from_transform(name: str, size: tuple[int, int], values: dict[str, Any], where: str) -> Camera:
    """Return the OpenCV camera of a photograph of `size` (width, height), lens distortion left aside.

    `values` are those of the frame and, where it has none, of the file. They may be for a picture of another size,
    which is scaled.

    Raises:
        InputError: values that are no camera, an unknown kind of lens, or an aspect ratio other than the picture's.
    """
    lens = str(values.get("camera_model", ""))
    if lens not in _LENSES or values.get("is_fisheye"):
        problem = f"the lens is of the kind {lens or 'fisheye'}"
        raise InputError(where, problem, "undistort the pictures to pinhole or OPENCV cameras first")
    width, height = _number(values, "w", where, size[0]), _number(values, "h", where, size[1])
    if not (width > 0 and height > 0):
        raise InputError(where, f"w and h are {width:g} and {height:g}", "they are the picture's sides in pixels")
    sx, sy = size[0] / width, size[1] / height
    if abs(sx / sy - 1.0) > 0.02:  # rounding a side to whole or even pixels stays below this
        problem = f"the camera is for {width:g}x{height:g} pixels and the picture has {size[0]}x{size[1]}"
        raise InputError(where, problem, "scale the pictures without cropping")
    fx = _focal(values, "fl_x", "camera_angle_x", width, where)
    if fx is None:
        raise InputError(where, "neither fl_x nor camera_angle_x is given", "add the focal length in pixels")
    fy = _focal(values, "fl_y", "camera_angle_y" if "fl_x" not in values else "", height, where) or fx
    cx, cy = _number(values, "cx", where, width / 2), _number(values, "cy", where, height / 2)
    try:
        pose = np.array(values["transform_matrix"], np.float64)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(where, f"transform_matrix is not a matrix of numbers ({error!r})") from error
    if pose.shape not in ((4, 4), (3, 4)) or not np.isfinite(pose).all():
        raise InputError(where, "transform_matrix is not a finite 4x4 matrix", "restore the poses")
    world_to_camera = np.eye(4)
    # Rows are the camera's axes in the world; OpenGL's y and z axes point the other way.
    world_to_camera[:3, :3] = pose[:3, :3].T * np.array([[1.0], [-1.0], [-1.0]])
    world_to_camera[:3, 3] = -world_to_camera[:3, :3] @ pose[:3, 3]
    try:
        return Camera(name, *size, fx * sx, fy * sy, cx * sx, cy * sy, world_to_camera)
    except InputError as error:
        raise InputError(where, error.problem, error.cure) from error


def _read_meta(path: Path) -> dict[str, Any]:
    try:
        meta: Any = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(path, f"unreadable ({error})", "restore the file from its source") from error
    frames = meta.get("frames") if isinstance(meta, dict) else None
    if not isinstance(frames, list) or not frames or not all(isinstance(frame, dict) for frame in frames):
        raise InputError(path, "frames is not a list of objects", "restore the file from its source")
    return dict(meta)


def _require_one_moment(where: Path, frames: list[dict[str, Any]]) -> None:
    """Refuse videos in this layout rather than take all their moments for one."""
    moments = {json.dumps(frame["time"]) for frame in frames if "time" in frame}
    if len(moments) > 1:
        cure = "this layout is for photographs of a still scene; give videos in the N3DV layout"
        raise InputError(where, f"its frames were taken at {len(moments)} different moments", cure)


def _picture_name(where: Path, number: int, frame: dict[str, Any]) -> Path:
    name = frame.get("file_path")
    if not isinstance(name, str) or not name:
        raise InputError(f"{where}, frame {number}", f"file_path is {name!r}", "it is the name of a picture")
    if Path(name).is_absolute() or ".." in Path(name).parts:
        raise InputError(f"{where}, frame {number}", f"file_path {name!r} is outside the capture", "move it below")
    return Path(name)


def _camera_names(root: Path, files: list[Path]) -> list[str]:
    """Return the files' names without their endings, or with their folders where these would not differ."""
    stems = [file.stem for file in files]
    if len(set(stems)) == len(stems):
        return stems
    return [file.relative_to(root).with_suffix("").as_posix() for file in files]


def _missing_note(missing: list[str], listed: int) -> str:
    named = ", ".join(missing[:_MOST_NAMED]) + (", ..." if len(missing) > _MOST_NAMED else "")
    return f"{len(missing)} of the {listed} pictures that {TRANSFORMS_FILE} lists are not there and left out: {named}"


def _focal(values: dict[str, Any], name: str, angle_name: str, side: float, where: str) -> float | None:
    """Return the focal length in pixels, given or from the angle of view in radians."""
    if name in values:
        return _number(values, name, where)
    if angle_name in values:
        angle = _number(values, angle_name, where)
        if not 0 < angle < math.pi:
            raise InputError(where, f"{angle_name} is {angle:g}", "it is an angle of view in radians")
        return side / 2 / math.tan(angle / 2)
    return None


def _number(values: dict[str, Any], name: str, where: str, default: float | None = None) -> float:
    value = values.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise InputError(where, f"{name} is {value!r}", "it is a number")
    return float(value)


def _outline(path: Path) -> Outline:
    """Return the cameras of the photographs that are there; they show one moment."""
    where = path / TRANSFORMS_FILE
    files = [path / _picture_name(where, number, frame) for number, frame in enumerate(_read_meta(where)["frames"])]
    return Outline(tuple(_camera_names(path, [file for file in files if file.is_file()])), 1, 0.0)


NERFSTUDIO = Layout(
    "nerfstudio", f"{TRANSFORMS_FILE}, images/", lambda names: TRANSFORMS_FILE in names, load_transforms, _outline
)
