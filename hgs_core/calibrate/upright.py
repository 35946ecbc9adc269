"""The up direction, size and origin of a rig, which pictures alone do not determine."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.calibrate.structure import Solution

__all__ = ["Distance", "placed"]

_LEVEL = 0.05  # share of the second smallest spread: below it, the cameras' own right-hand directions say what is level

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Distance:
    """A distance that was measured between two cameras."""

    first: str
    second: str
    metres: float


def placed(
    solution: Solution, up: str | None = None, distance: Distance | None = None, *, metric: bool = False
) -> Solution:
    """Return the solution with y pointing down, its origin where the cameras look, and its scale.

    Without `up` the cameras are taken to be held level: what is level is the plane of their right-hand directions. `up`
    is the name of a camera whose picture is upright. Without `distance` the cameras are 1 away from the origin
    on average, unless the solution is `metric` and stays as large as it is.

    Raises:
        InputError: there is no camera of a name, or the two of the distance stand at one place.
    """
    poses = {camera.name: camera.world_to_camera for camera in solution.cameras}
    down = _camera(poses, "--up", up)[1, :3] if up is not None else _down(list(poses.values()))
    centres = {name: -pose[:3, :3].T @ pose[:3, 3] for name, pose in poses.items()}
    origin = _looked_at(list(poses.values()))
    if metric:
        scale = 1.0
    elif distance is None:
        scale = 1 / float(np.mean([np.linalg.norm(centre - origin) for centre in centres.values()]))
    else:
        for name in (distance.first, distance.second):
            _camera(poses, "--distance", name)
        apart = float(np.linalg.norm(centres[distance.first] - centres[distance.second]))
        if apart < 1e-9:
            raise InputError("--distance", f"{distance.first} and {distance.second} stand at one place", "name others")
        scale = distance.metres / apart
    turn = _turn(down, solution.cameras[0].world_to_camera[2, :3])
    cameras = []
    for camera in solution.cameras:
        pose = np.eye(4)
        pose[:3, :3] = camera.world_to_camera[:3, :3] @ turn.T
        pose[:3, 3] = -pose[:3, :3] @ (turn @ (centres[camera.name] - origin) * scale)
        cameras.append(dataclasses.replace(camera, world_to_camera=pose))
    points = (solution.points - origin) @ turn.T * scale
    return Solution(tuple(cameras), np.asarray(points), solution.error)


def _camera(poses: dict[str, Floats], option: str, name: str) -> Floats:
    if name not in poses:
        raise InputError(f"{option} {name}", "there is no such camera", f"the cameras are {', '.join(poses)}")
    return poses[name]


def _down(poses: list[Floats]) -> Floats:
    """Return the direction that all cameras' right-hand directions are square to, downwards as their pictures are."""
    rights, downs = np.array([pose[0, :3] for pose in poses]), np.array([pose[1, :3] for pose in poses])
    middle = downs.mean(axis=0)
    values, vectors = np.linalg.eigh(rights.T @ rights / len(rights))
    if values[1] - values[0] < _LEVEL:  # the cameras look in one direction: right-hand directions leave a plane open
        return np.asarray(middle / np.linalg.norm(middle))
    level = vectors[:, 0]
    return np.asarray(level if level @ middle > 0 else -level)


def _looked_at(poses: list[Floats]) -> Floats:
    """Return the point nearest to all cameras' lines of sight."""
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for pose in poses:
        across = np.eye(3) - np.outer(pose[2, :3], pose[2, :3])
        normal += across
        right += across @ (-pose[:3, :3].T @ pose[:3, 3])
    return np.asarray(np.linalg.lstsq(normal, right, rcond=1e-6)[0])


def _turn(down: Floats, forward: Floats) -> Floats:
    """Return the rotation [3, 3] that brings `down` to y and the level part of `forward` to z."""
    ahead = forward - (forward @ down) * down
    if np.linalg.norm(ahead) < 1e-6:  # it looks straight down
        ahead = np.cross(down, [1.0, 0.0, 0.0]) if abs(down[0]) < 0.9 else np.cross(down, [0.0, 0.0, 1.0])
    ahead = ahead / np.linalg.norm(ahead)
    return np.array([np.cross(down, ahead), down, ahead])
