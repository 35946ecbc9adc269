"""Writing cameras in COLMAP's text form: cameras.txt, images.txt, points3D.txt."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.atomic import write_bytes
from hgs_core.calibrate.structure import Solution
from hgs_core.scene.rotations import quaternions_of

__all__ = ["write_colmap_text"]


def write_colmap_text(folder: Path, solution: Solution) -> None:
    """Write a solution into `folder`; images are called as their cameras. cameras.txt comes last.

    Cameras of one size, model and parameters share a line of cameras.txt.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lenses: dict[tuple[object, ...], int] = {}
    images = ["# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME, then a line of points (none)"]
    for number, camera in enumerate(solution.cameras, 1):
        lens = (camera.model, camera.width, camera.height, *camera.parameters)
        identity = lenses.setdefault(lens, len(lenses) + 1)
        pose = (*quaternions_of(camera.world_to_camera[:3, :3]), *camera.world_to_camera[:3, 3])
        images += [f"{number} {_numbers(pose)} {identity} {camera.name}", ""]
    cameras = ["# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]"]
    for (model, width, height, *parameters), identity in lenses.items():
        cameras.append(f"{identity} {model} {width} {height} {_numbers(parameters)}")
    points = ["# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] (none)"]
    points += [f"{number} {_numbers(point)} 128 128 128 0" for number, point in enumerate(solution.points, 1)]
    for name, lines in (("points3D.txt", points), ("images.txt", images), ("cameras.txt", cameras)):
        write_bytes(folder / name, ("\n".join(lines) + "\n").encode())


def _numbers(values: Sequence[object] | npt.NDArray[np.float64]) -> str:
    return " ".join(f"{float(str(value)):.12g}" for value in values)
