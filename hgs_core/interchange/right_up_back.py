"""Between our axes, right, down, forward (OpenCV), and right, up, back (OpenGL), which SPZ and glTF store.

That is half a turn about x: y and z change their signs, of places and of the vector parts of quaternions alike.
"""

from __future__ import annotations

import numpy as np

from hgs_core.base.arrays import Doubles, Floats

__all__ = ["other_way_up", "our_rotations", "stored_rotations"]

_FLIP = np.array([1.0, -1.0, -1.0])


def other_way_up(places: Doubles | Floats) -> Doubles:
    """Return places or vectors [N, 3] in the other axes, whichever these are."""
    return np.asarray(places * _FLIP)


def stored_rotations(quats: Doubles) -> Doubles:
    """Return quaternions w, x, y, z [N, 4] of our axes as x, y, z, w of theirs."""
    return np.concatenate([quats[:, 1:] * _FLIP, quats[:, :1]], axis=1)


def our_rotations(xyzw: Doubles) -> Doubles:
    """Return quaternions x, y, z, w [N, 4] of theirs as w, x, y, z of ours."""
    return np.concatenate([xyzw[:, 3:], xyzw[:, :3] * _FLIP], axis=1)
