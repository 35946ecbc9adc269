"""From where the pictures of a scene were taken: an arc, a dome, a window, found from the cameras."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hgs_core.base.arrays import Doubles
from hgs_core.codec.format.captured_space import CapturedSpace
from hgs_core.scene.camera import FAR_APART, Camera, neighbour_angle

__all__ = ["find_captured_space"]

Triple = tuple[float, float, float]

MARGIN = (math.radians(5), math.radians(15))
"""The least and largest angle beyond the outermost camera, radians.

In between it is the typical angle from a camera to the next: a scene that is right from two cameras is about right
between them, and about as far beyond them.
"""

WIDEST_GAP = math.radians(90)  # between neighbours of a circle that is closed
SURROUNDED = math.radians(180)  # gap below which cameras stand on all sides of the subject
STEEPEST = math.radians(75)  # elevation from which on an azimuth says nothing
CLOSER, FARTHER = 0.5, 1.25
"""Of the nearest and of the farthest camera's distance. At half the distance the capture's pixels are two pixels wide;
from farther away the rims of the pictures and the space behind the cameras come into view."""


def find_captured_space(
    cameras: Sequence[Camera], center: Triple, up: Triple, *, moves: bool = True
) -> CapturedSpace | None:
    """Return the space around `center` from which `cameras` look, with a margin; `up` is a unit vector.

    A sparse rig gets a cone per camera, for what stands still, and is open all round where it surrounds what moves;
    not so a scene in which nothing `moves`.

    None if most of them do not look towards the centre: they stand in the middle and look around, and to turn about
    the centre is of no use there.
    """
    offsets = np.array([camera.position for camera in cameras]).reshape(-1, 3) - center
    axes = np.array([camera.world_to_camera[2, :3] for camera in cameras]).reshape(-1, 3)
    inward = (offsets * axes).sum(axis=1) < 0
    if inward.sum() * 2 <= len(cameras):
        return None
    offsets = offsets[inward]
    distances = np.linalg.norm(offsets, axis=1)
    directions = offsets / distances[:, None]
    elevations = np.arcsin(np.clip(directions @ up, -1, 1))
    apart = neighbour_angle(directions)
    margin = float(np.clip(apart, *MARGIN))
    sparse = moves and apart > FAR_APART
    closed = SURROUNDED - 1e-6 if sparse else WIDEST_GAP
    front, azimuth = _azimuths(directions[np.abs(elevations) < STEEPEST], np.asarray(up), margin, closed)
    low, high = float(elevations.min()) - margin, float(elevations.max()) + margin
    return CapturedSpace(
        front,
        azimuth,
        (max(low, -math.pi / 2), min(high, math.pi / 2)),
        (float(distances.min()) * CLOSER, float(distances.max()) * FARTHER),
        cones=tuple(map(_triple, directions)) if sparse else (),
    )


def _azimuths(directions: Doubles, up: Doubles, margin: float, closed: float) -> tuple[Triple, float | None]:
    """Return the middle of the arc that holds all directions [N, 3], a unit vector, and half its width with the margin.

    The arc is what is left of the circle without its widest gap. Without a gap above `closed`, radians, it is all
    round, and the middle is the first direction.
    """
    first = _horizontal(directions[0] if len(directions) else np.eye(3)[np.abs(up).argmin()], up)
    side = np.cross(up, first)
    angles = np.sort(np.arctan2(directions @ side, directions @ first))
    if not len(angles):
        return _triple(first), None
    gaps = np.diff(angles, append=angles[0] + 2 * math.pi)
    widest = int(gaps.argmax())
    if gaps[widest] <= closed:
        return _triple(first), None
    width = 2 * math.pi - gaps[widest]
    middle = angles[widest] - width / 2  # the arc ends where the gap begins
    return _triple(first * math.cos(middle) + side * math.sin(middle)), float(width / 2 + margin)


def _horizontal(direction: Doubles, up: Doubles) -> Doubles:
    flat = direction - up * (direction @ up)
    return np.asarray(flat / np.linalg.norm(flat))


def _triple(vector: Doubles) -> Triple:
    x, y, z = (float(v) for v in vector)
    return x, y, z
