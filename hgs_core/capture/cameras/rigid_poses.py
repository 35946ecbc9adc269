"""Poses as files have them become rotations and translations: a uniform scale is taken out, a mirror is refused."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.cameras.rig import CalibratedCamera, Rig

__all__ = ["with_rigid_poses"]

_ORTHONORMAL = 1e-3  # tolerance of `Camera` on products of the rotation's rows
_LARGEST_SCALE = 1e6  # and its inverse: what lies beyond is damage


def with_rigid_poses(rig: Rig) -> Rig:
    """Return the rig with poses that turn and move only, and a note of the scale that was taken out.

    A pose that scales all axes alike shows every point in the same pixel as the pose without the scale: world to camera
    [s R | t] is [R | t / s].

    Raises:
        InputError: a pose mirrors, or is no rotation at any scale.
    """
    scales = [_scale(camera) for camera in rig.cameras]
    if all(scale == 1.0 for scale in scales):
        return rig
    cameras = [
        camera if scale == 1.0 else dataclasses.replace(camera, world_to_camera=_divided(camera.world_to_camera, scale))
        for camera, scale in zip(rig.cameras, scales, strict=True)
    ]
    scaled = [scale for scale in scales if scale != 1.0]
    low, high = min(scaled), max(scaled)
    by = f"{low:.4g}" if f"{low:.4g}" == f"{high:.4g}" else f"{low:.4g} to {high:.4g}"
    note = f"the poses of {counted(len(scaled), 'camera')} have a scale of {by}, which is taken out"
    return dataclasses.replace(rig, cameras=cameras, notes=(*rig.notes, note))


def _scale(camera: CalibratedCamera) -> float:
    """Return the scale of a pose: 1 if its rotation is one."""
    turn = camera.world_to_camera[:3, :3]
    if _is_orthonormal(turn):
        scale = 1.0
    else:
        lengths = np.linalg.norm(turn, axis=1)
        scale = float(lengths.mean())
        if not (1 / _LARGEST_SCALE < scale < _LARGEST_SCALE and _is_orthonormal(turn / scale)):
            rows = ", ".join(f"{length:.4g}" for length in lengths)
            problem = f"the rotation of its pose is none: its rows have the lengths {rows} and are not at right angles"
            if np.ptp(lengths) > _ORTHONORMAL * max(scale, 1e-9):
                problem = f"the rotation of its pose is none: its rows have the lengths {rows}, not one"
            raise InputError(camera.where, problem, "export the poses again without shear or scale of single axes")
    if np.linalg.det(turn) < 0:
        cure = (
            "export with right-handed axes; of a left-handed world (Unity, Unreal), negate the third row of every"
            " camera-to-world matrix, or the third column of every world-to-camera matrix"
        )
        raise InputError(camera.where, "its pose is a reflection, which mirrors the scene", cure)
    return scale


def _is_orthonormal(turn: npt.NDArray[np.float64]) -> bool:
    return bool(np.abs(turn).max() <= 2 and np.allclose(turn @ turn.T, np.eye(3), atol=_ORTHONORMAL))


def _divided(pose: npt.NDArray[np.float64], scale: float) -> npt.NDArray[np.float64]:
    found = pose / scale
    found[3] = (0.0, 0.0, 0.0, 1.0)
    return found
