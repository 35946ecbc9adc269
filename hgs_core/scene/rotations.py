"""Unit quaternions w, x, y, z; a quaternion of no length is the identity, as in rendering (docs/numerics.md)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles

__all__ = ["matrices", "product", "quaternions_of", "unit_quaternions", "units_and_norms"]

SHORTEST = 1e-12  # |q|^2 < 1e-24


def units_and_norms(quaternions: NDArray[np.floating[Any]]) -> tuple[Doubles, Doubles]:
    """Return unit quaternions [N, 4] in float64, and the norms [N, 1] that they had: 1 for those of no length."""
    given = np.asarray(quaternions, np.float64)
    norms = np.linalg.norm(given, axis=1, keepdims=True)
    short = norms < SHORTEST
    norms = np.where(short, 1.0, norms)
    return np.where(short, (1.0, 0.0, 0.0, 0.0), given / norms), norms


def unit_quaternions(quaternions: NDArray[np.floating[Any]]) -> Doubles:
    """Return quaternions [N, 4] at unit length, in float64."""
    return units_and_norms(quaternions)[0]


def product(a: Doubles, b: Doubles) -> Doubles:
    """Return the Hamilton product of quaternions [..., 4], w first."""
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def matrices(quats: Doubles) -> Doubles:
    """Return rotation matrices [..., 3, 3] of unit quaternions [..., 4]."""
    w, x, y, z = np.moveaxis(quats, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternions_of(turns: Doubles) -> Doubles:
    """Return quaternions [..., 4], w at least 0, of rotations [..., 3, 3]: eigenvectors by Bar-Itzhack (2000)."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = np.moveaxis(turns.reshape(*turns.shape[:-2], 9), -1, 0)
    rows = [
        [xx + yy + zz, zy - yz, xz - zx, yx - xy],
        [zy - yz, xx - yy - zz, yx + xy, zx + xz],
        [xz - zx, yx + xy, yy - xx - zz, zy + yz],
        [yx - xy, zx + xz, zy + yz, zz - xx - yy],
    ]
    symmetric = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    quats = np.linalg.eigh(symmetric / 3)[1][..., -1]
    return np.where(quats[..., :1] < 0, -quats, quats)
