"""Cameras of caliscope (camera_array.toml), Pose2Sim and anipose (Calib*.toml): one table for each camera.

A table holds `size`, `matrix` [3, 3], `distortions` as OpenCV orders them, `rotation` (a matrix or the axis times the
angle) and `translation` from the world to the camera, and perhaps `fisheye` and `name`. OpenCV made these files and
counts pixels from the centre of the first one; here it lies at 0.5.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown
from hgs_core.capture.cameras.rig import (
    CalibratedCamera,
    CameraFormat,
    Rig,
    finite,
    lens_numbers,
    pose_of,
    rotation_matrix,
)
from hgs_core.capture.files.text_file import read_toml
from hgs_core.capture.lenses.lens import opencv_lens
from hgs_core.capture.pictures.picture import list_folder, list_folders

__all__ = ["CALIBRATION_TOML", "OPENCV_CENTRE"]

OPENCV_CENTRE = 0.5
"""Pixels from OpenCV's principal point to ours: centres of pixels lie at whole numbers there."""


def _read(capture: Path, file: Path) -> Rig:
    others = [other.name for other in _candidates(file.parent) if other != file]
    if others and file.name.lower() != "camera_array.toml":
        raise InputError(file, f"{', '.join(others)} lies beside it", "keep the calibration that is to be used alone")
    content = read_toml(file, "restore the file from its source")
    tables = content.get("cameras", content)
    if not isinstance(tables, dict):
        raise InputError(file, f"cameras is {shown(tables)}", "each camera has a table with its matrix")
    cameras = {name: table for name, table in tables.items() if isinstance(table, dict) and "matrix" in table}
    used = {name: table for name, table in cameras.items() if table.get("ignore") is not True}
    if not used:
        raise InputError(file, "lists no camera", "each camera has a table with its matrix")
    ignored = ", ".join(name for name in cameras if name not in used)
    notes = (f"{file.name} says that {ignored} is to be left out",) if ignored else ()
    return Rig((file,), [_camera(name, table, f"{file}, {name}") for name, table in used.items()], notes=notes)


def _camera(name: str, table: dict[str, Any], where: str) -> CalibratedCamera:
    for field in ("size", "rotation", "translation"):
        if table.get(field) is None:
            cure = "add it: size = [width, height]"
            if field != "size":
                cure = 'calibrate where the cameras stand, not their lenses alone, or add "ignore = true"'
            raise InputError(where, f"the field {field!r} is missing", cure)
    width, height = finite(table["size"], 2, where, "size")
    matrix = finite(table["matrix"], 9, where, "matrix").reshape(3, 3)
    distortions = lens_numbers(table.get("distortions"), where, "distortions")
    fisheye = table.get("fisheye") is True
    try:
        lens = opencv_lens(distortions, fisheye)
    except ValueError as error:
        raise InputError(where, f"distortions: {error}", "undistort the pictures first") from error
    pose = pose_of(rotation_matrix(table["rotation"], f"{where}, rotation"), table["translation"], where)
    return CalibratedCamera(
        where,
        tuple(dict.fromkeys((str(table.get("name", name)), name))),
        pose,
        (float(matrix[0, 0]), float(matrix[1, 1])),
        (float(matrix[0, 2]) + OPENCV_CENTRE, float(matrix[1, 2]) + OPENCV_CENTRE),
        (float(width), float(height)),
        lens,
    )


def _candidates(folder: Path) -> list[Path]:
    names = sorted(name for name in list_folder(folder) if name.lower().endswith(".toml"))
    return [folder / name for name in names if name.lower().startswith("calib") or name.lower() == "camera_array.toml"]


def _find(capture: Path) -> Path | None:
    below = [capture / name for name in list_folders(capture) if name.lower() == "calibration"]
    found = [file for folder in (capture, *below) for file in _candidates(folder)]
    return min(found, key=lambda file: file.name.lower() != "camera_array.toml", default=None)


CALIBRATION_TOML = CameraFormat("caliscope, Pose2Sim", "camera_array.toml or calibration/Calib*.toml", _find, _read)
