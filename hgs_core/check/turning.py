"""The angle between a camera and its stated pose."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from hgs_core.check.epipolar import Pairs, Rig, signed_distances

__all__ = ["turned_to_fit"]

_STEPS = 15  # Gauss-Newton steps
_PROBE = 1e-5  # radians

Floats = npt.NDArray[np.float64]


def turned_to_fit(rig: Rig, pairs: Pairs, camera: int) -> tuple[Floats, float]:
    """Turn one camera where it stands until its matches lie on their lines, most of them.

    Robust Gauss-Newton (weights of Geman and McClure) over the rotation alone.

    Returns:
        The pose [4, 4], and by how many degrees it is turned from the one in `rig`.
    """
    centre, begun = rig.centres()[camera], rig.poses[camera, :3, :3]
    turn = begun.copy()

    def posed(rotation: Floats) -> Rig:
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation, -rotation @ centre
        return rig.with_pose(camera, pose)

    def residuals(rotation: Floats) -> Floats:
        turned = posed(rotation)
        return np.concatenate(
            [signed_distances(turned.fundamental(a, b), one.first, one.second) for (a, b), one in pairs.items()]
        )

    for _ in range(_STEPS):
        now = residuals(turn)
        slopes = np.stack([(residuals(_rotation(_PROBE * axis) @ turn) - now) / _PROBE for axis in np.eye(3)], axis=1)
        scale = max(1.0, float(np.median(np.abs(now))))
        weights = 1 / (1 + (now / scale) ** 2) ** 2
        normal = slopes.T @ (weights[:, None] * slopes) + 1e-9 * np.eye(3)
        step = -np.linalg.solve(normal, slopes.T @ (weights * now))
        shorter = min(1.0, 0.2 / max(1e-12, float(np.linalg.norm(step))))
        turn = _rotation(np.asarray(step * shorter, np.float64)) @ turn
    cosine = (np.trace(turn @ begun.T) - 1) / 2
    return posed(turn).poses[camera], float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def _rotation(vector: Floats) -> Floats:
    """Return the rotation [3, 3] about a vector by its length in radians (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-15:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross))
