"""Paths as straight pieces, for formats of splats with one velocity and no rotation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.scene.motion import position
from hgs_core.scene.rotations import unit_quaternions
from hgs_core.scene.splats import DynamicSplats
from hgs_core.scene.temporal import lifetime

__all__ = ["Pieces", "straight_pieces"]

MOST = 32  # pieces of a segment
SHARE = 0.5  # allowed error of the outline, share of a splat's middle axis
SAMPLES = 9  # points of a piece compared with the path


@dataclass(frozen=True)
class Pieces:
    """Pieces of paths [P]: each is shown for a part of the segment, with ends in shares of MOST."""

    splats: NDArray[np.intp]  # index of the splat
    starts: Doubles  # normalised time from which it is shown
    ends: Doubles
    means: Doubles  # [P, 3], at the splat's temporal centre
    velocities: Doubles  # [P, 3], for the segment's whole time
    quats: Doubles  # [P, 4], unit, w first
    error: float  # the largest one of any place, world units


def straight_pieces(dynamic: DynamicSplats[Floats]) -> Pieces:
    """Return pieces that leave no outline by more than half of its middle axis, if MOST of them suffice for that.

    Of the parts of a segment, 1, 2, 4 to MOST, a splat has the fewest that suffice, and of these those in which it
    can be seen. Within its visible life a piece leads from the path's place at its beginning to that at its end.
    """
    first, last = (np.clip(np.nan_to_num(end, posinf=2, neginf=-2), 0, 1) for end in lifetime(dynamic))
    alive = lifetime(dynamic)[0] <= np.minimum(1, lifetime(dynamic)[1])
    alive &= lifetime(dynamic)[1] >= 0
    waiting = np.flatnonzero(alive)
    axes = np.sort(np.exp(dynamic.log_scales.astype(np.float64)), axis=1)
    found = []
    parts, error = 1, 0.0
    while len(waiting):
        edges = np.arange(parts) / parts
        starts = np.maximum(edges, first[waiting, None])
        ends = np.minimum(edges + 1 / parts, last[waiting, None])
        rows, part = np.nonzero(starts <= ends)
        which = waiting[rows]
        piece, off, turned = _pieces(dynamic, which, starts[rows, part], ends[rows, part])
        enough = np.ones(len(dynamic), np.bool_)
        enough[which[off + turned * axes[which, 2] > SHARE * axes[which, 1]]] = parts == MOST
        kept = enough[which]
        error = max(error, float(off[kept].max(initial=0.0)))
        shown = part[kept] / parts
        found.append((which[kept], shown, shown + 1 / parts, *(array[kept] for array in piece)))
        waiting = waiting[~enough[waiting]]
        parts *= 2
    if not found:
        none = np.zeros(0)
        return Pieces(np.zeros(0, np.intp), none, none, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4)), 0.0)
    which, *rest = (np.concatenate(column) for column in zip(*found, strict=True))
    return Pieces(which, rest[0], rest[1], rest[2], rest[3], rest[4], error)


def _pieces(
    dynamic: DynamicSplats[Floats], which: NDArray[np.intp], starts: Doubles, ends: Doubles
) -> tuple[tuple[Doubles, Doubles, Doubles], Doubles, Doubles]:
    """Return places, velocities and rotations of pieces, and by how much each is off: world units, radians."""
    center = dynamic.time_centers[which].astype(np.float64)
    offsets = starts[:, None] + (ends - starts)[:, None] * np.linspace(0, 1, SAMPLES) - center[:, None]  # [P, SAMPLES]
    path = position(dynamic.motion[which].astype(np.float64)[:, None], offsets[..., None])
    span = (ends - starts)[:, None]
    velocities = np.where(span > 0, (path[:, -1] - path[:, 0]) / np.where(span > 0, span, 1), 0.0)
    means = path[:, 0] - velocities * offsets[:, :1]
    off = np.linalg.norm(means[:, None] + velocities[:, None] * offsets[..., None] - path, axis=2)
    turns = dynamic.rotation[which].astype(np.float64)
    quats = unit_quaternions((turns[:, None, 0] + offsets[..., None] * turns[:, None, 1]).reshape(-1, 4))
    quats = quats.reshape(len(which), SAMPLES, 4)
    middle = quats[:, SAMPLES // 2]
    angles = 2 * np.arccos(np.clip(np.abs((quats * middle[:, None]).sum(axis=2)), 0, 1))
    return (means, velocities, middle), off.max(axis=1), angles.max(axis=1)
