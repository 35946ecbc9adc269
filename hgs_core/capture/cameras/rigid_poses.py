"""Poses as files have them become rotations and translations: a uniform scale and a left-handed world are undone."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.cameras.rig import CalibratedCamera, Rig
from hgs_core.scene.camera import ORTHONORMAL, is_orthonormal

__all__ = ["MIRROR", "with_rigid_poses"]

MIRROR = np.diag((-1.0, 1.0, 1.0, 1.0))
"""The mirror of a world: of x, which is up in none."""

_LARGEST_SCALE = 1e6  # and its inverse: what lies beyond is damage
_MOST_NAMED = 6  # cameras that a message lists


def with_rigid_poses(rig: Rig) -> Rig:
    """Return the rig with poses that turn and move only, and notes of the scale and the mirror that were taken out.

    A pose that scales all axes alike shows every point in the same pixel as the pose without the scale: world to camera
    [s R | t] is [R | t / s].

    Raises:
        InputError: some poses mirror and some do not, or a pose is no rotation at any scale.
    """
    scales = [_scale(camera) for camera in rig.cameras]
    rig = _right_handed(rig)
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
    if is_orthonormal(turn):
        scale = 1.0
    else:
        lengths = np.linalg.norm(turn, axis=1)
        scale = float(lengths.mean())
        if not (1 / _LARGEST_SCALE < scale < _LARGEST_SCALE and is_orthonormal(turn / scale)):
            rows = ", ".join(f"{length:.4g}" for length in lengths)
            problem = f"the rotation of its pose is none: its rows have the lengths {rows} and are not at right angles"
            if np.ptp(lengths) > ORTHONORMAL * max(scale, 1e-9):
                problem = f"the rotation of its pose is none: its rows have the lengths {rows}, not one"
            raise InputError(camera.where, problem, "export the poses again without shear or scale of single axes")
    return scale


def _right_handed(rig: Rig) -> Rig:
    """Return the rig with x of the world turned if all poses are reflections: which axes are meant is for the check."""
    mirrors = [bool(np.linalg.det(camera.world_to_camera[:3, :3]) < 0) for camera in rig.cameras]
    if not any(mirrors):
        return rig
    if not all(mirrors):
        named = [camera.where for camera, mirror in zip(rig.cameras, mirrors, strict=True) if mirror]
        listed = "; ".join(named[:_MOST_NAMED]) + ("; ..." if len(named) > _MOST_NAMED else "")
        problem = f"{len(named)} of {len(mirrors)} poses are reflections, which mirror the scene"
        raise InputError(rig.files[0], f"{problem}: {listed}", "export all poses with the same axes")
    cameras = [dataclasses.replace(camera, world_to_camera=camera.world_to_camera @ MIRROR) for camera in rig.cameras]
    note = "all poses are reflections, as of a left-handed world (Unity, Unreal): x of the world is turned"
    return dataclasses.replace(rig, cameras=cameras, mirrored=True, notes=(*rig.notes, note))


def _divided(pose: npt.NDArray[np.float64], scale: float) -> npt.NDArray[np.float64]:
    found = pose / scale
    found[3] = (0.0, 0.0, 0.0, 1.0)
    return found
