"""Cameras of N3DV (Neural 3D Video) and LLFF captures: poses_bounds.npy.

It follows LLFF (Mildenhall et al., SIGGRAPH 2019): one row of 17 values per camera in the order of the cameras' names,
a 3x5 matrix [R | t | (height, width, focal)] and the nearest and farthest depth. [R | t] is camera-to-world and the
columns of R point down, right and backwards.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.rig import LARGEST, MOST_CAMERAS, CalibratedCamera, CameraFormat, Rig
from hgs_core.capture.files.array_file import read_array

__all__ = ["LLFF", "POSES_FILE", "camera_of_row"]

POSES_FILE = "poses_bounds.npy"


def camera_of_row(row: npt.NDArray[np.float64], where: str) -> CalibratedCamera:
    """Return the camera of a row [17]; the principal point is the middle of the picture.

    Raises:
        InputError: values that are no camera.
    """
    if not (np.abs(row) < LARGEST).all():
        raise InputError(where, "the pose holds NaN, infinity or more than 1e30", "estimate the cameras again")
    matrix = row[:15].reshape(3, 5)
    height, width, focal = (float(value) for value in matrix[:, 4])
    if not (height > 0 and width > 0 and focal > 0):
        problem = f"(height, width, focal) is ({height:g}, {width:g}, {focal:g})"
        raise InputError(where, problem, "all three are positive, in pixels")
    down, right, back, position = matrix[:, 0], matrix[:, 1], matrix[:, 2], matrix[:, 3]
    world_to_camera = np.eye(4)
    world_to_camera[:3, :3] = np.stack((right, down, -back))  # rows: the x, y and z axes of the camera in the world
    world_to_camera[:3, 3] = -world_to_camera[:3, :3] @ position
    return CalibratedCamera(where, (), world_to_camera, (focal, focal), None, (width, height))


def _read(capture: Path, file: Path) -> Rig:
    rows = read_array(file, "restore the file from its source")
    if rows.ndim != 2 or rows.shape[1] != 17:
        raise InputError(file, f"the array is {rows.shape}", "LLFF writes one row of 17 values per camera")
    if len(rows) > MOST_CAMERAS:
        raise InputError(file, f"has {len(rows)} rows", f"a capture has at most {MOST_CAMERAS} cameras, one row each")
    return Rig((file,), [camera_of_row(row, f"{file}, row {number}") for number, row in enumerate(rows)])


def _find(capture: Path) -> Path | None:
    return file if (file := capture / POSES_FILE).is_file() else None


LLFF = CameraFormat("N3DV", POSES_FILE, _find, _read)
