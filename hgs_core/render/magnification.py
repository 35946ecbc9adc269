"""How much larger a view shows things than the pictures that made a scene (docs/numerics.md, "Magnification")."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hgs_core.render.constants import MAGNIFICATION_SLACK
from hgs_core.scene.camera import Camera

__all__ = ["magnification"]

TINY = 1e-300  # world units squared


def magnification(camera: Camera, rig: Sequence[Camera]) -> npt.NDArray[np.float64]:
    """Return the magnification of a view, [4] a, b, c, d; zeros without a rig.

    A point (x, y, z) in the view shows (a x + b y + c z + d) / z times as large as the cameras of the rig beside the
    view showed it.

    Args:
        camera: the view.
        rig: cameras of the pictures that made the scene, at the size of those pictures.
    """
    if not rig:
        return np.zeros(4)
    poses = np.array([other.world_to_camera for other in rig])  # [C, 4, 4]
    # World units per pixel at a point: an affine function for each camera, and for a mean of them.
    finest = np.array([max(other.fx, other.fy) for other in rig])
    spacing = weights(camera, rig) @ (poses[:, 2] / finest[:, None])  # [4]
    R, shift = camera.world_to_camera[:3, :3], camera.world_to_camera[:3, 3]
    turned = R @ spacing[:3]
    in_view = np.append(turned, spacing[3] - turned @ shift)
    return in_view * (max(camera.fx, camera.fy) * MAGNIFICATION_SLACK)


def weights(camera: Camera, rig: Sequence[Camera]) -> npt.NDArray[np.float64]:
    """Return the weights [C] of a rig's cameras for a view; their sum is 1, all of it on a camera in the same pose."""
    places = np.array([other.position for other in rig])
    axes = np.array([other.world_to_camera[2, :3] for other in rig])
    away = ((places - camera.position) ** 2).sum(axis=1)
    apart = away + away.max() * np.maximum(0.0, 1 - axes @ camera.world_to_camera[2, :3])
    near = ((apart.min() + TINY) / (apart + TINY)) ** 2
    return np.asarray(near / near.sum())
