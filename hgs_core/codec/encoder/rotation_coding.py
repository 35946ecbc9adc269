"""Quaternions of splats, and which of the equal ones is cheapest to store."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from hgs_core.scene.rotations import matrices, product

__all__ = ["canonical", "shape_error", "turn_between", "vector_to_quats"]

Doubles = NDArray[np.float64]


def vector_to_quats(vector: Doubles) -> Doubles:
    """Return unit quaternions [..., 4] with w >= 0 of vector parts [..., 3]."""
    w = np.sqrt(np.maximum(0.0, 1 - (vector**2).sum(axis=-1, keepdims=True)))
    return np.concatenate([w, vector], axis=-1)


def turn_between(a: Doubles, b: Doubles) -> Doubles:
    """Return the rotation from unit quaternions a to b [..., 4] about a's own axes, [..., 3], radians if small."""
    difference = product(a * (1.0, -1.0, -1.0, -1.0), b)
    sign = np.where(difference[..., :1] < 0, -2.0, 2.0)
    return difference[..., 1:] * sign


def _cube_rotations() -> dict[tuple[int, ...], Doubles]:
    """Return the 24 rotations of a cube [4, 4] for each order in which they leave the axes."""
    found: dict[tuple[int, ...], list[Doubles]] = {}
    for entries in itertools.product((-1.0, 0.0, 1.0), repeat=4):
        quat = np.array(entries)
        filled = np.flatnonzero(quat)
        if len(filled) in (1, 2, 4) and quat[filled[0]] > 0:
            quat = quat / np.linalg.norm(quat)
            found.setdefault(tuple(int(i) for i in np.abs(matrices(quat)).argmax(axis=0)), []).append(quat)
    return {order: np.array(quats) for order, quats in found.items()}


_CUBE = _cube_rotations()


def canonical(quats: Doubles, log_scales: Doubles) -> tuple[Doubles, Doubles]:
    """Return the cube rotation [N, 4] to multiply quaternions by from the right, and the log-scales in falling order.

    An ellipsoid looks the same with its axes renamed or turned round: of the 24 rotations that describe it, this
    takes the one that names the axes from longest to shortest and has the largest |w|, at least 1/2.
    """
    order = np.argsort(-log_scales, axis=1, kind="stable")
    turn = np.empty_like(quats)
    for axes, choices in _CUBE.items():
        members = np.flatnonzero((order == axes).all(axis=1))
        w = product(quats[members, None], choices)[..., 0]
        turn[members] = choices[np.abs(w).argmax(axis=1)]
    return turn, np.take_along_axis(log_scales, order, axis=1)


def shape_error(
    quats: Doubles, log_scales: Doubles, other_quats: Doubles, other_log_scales: Doubles, blur: float
) -> Doubles:
    """Return the largest |ln| [N] of the ratio of standard deviations in any direction, both shapes blurred.

    That is the larger one of ln |Db^-1 Rb^T Ra Da| and ln |Da^-1 Ra^T Rb Db|, with rotations R and blurred deviations
    D: no matrix is inverted, so that axes may differ by as much as numbers hold.
    """
    turn = np.swapaxes(matrices(quats), 1, 2) @ matrices(other_quats)
    deviations, others = (
        np.exp(np.logaddexp(2 * scales, 2 * np.log(blur)) / 2) for scales in (log_scales, other_log_scales)
    )
    larger = np.linalg.norm(turn * others[:, None, :] / deviations[:, :, None], 2, axis=(1, 2))
    smaller = np.linalg.norm(np.swapaxes(turn, 1, 2) * deviations[:, None, :] / others[:, :, None], 2, axis=(1, 2))
    return np.asarray(np.log(np.maximum(larger, smaller)))
