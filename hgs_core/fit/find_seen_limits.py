"""The limits of a captured space, beyond which a good part of the picture would show things unseen by the cameras."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.codec.format.captured_space import CapturedSpace, Place
from hgs_core.codec.format.seen_limits import Range, SeenLimits
from hgs_core.fit.seen_share import SeenShare
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.splats import HybridScene

__all__ = ["limits_where", "view_from", "with_seen_limits"]

Triple = tuple[float, float, float]

COLUMNS, COLUMNS_ALL_ROUND = 8, 12  # azimuths
ROWS, SHELLS = 5, 4  # elevations, distances
REQUIRED = 0.95  # share of a picture
ROOM = 0.5  # share of what stands still with a second view, below which viewers begin without it
SECOND = math.radians(40)  # largest angle between two views of a place
OWN = 0.1  # quantile of the shares at the cameras' own places, the most that is required
FILLED = 0.8  # least share of the cameras' pictures with something to see
DIGITS = 4  # digits of a number in the manifest
POLE = math.radians(89)  # steepest elevation of an eye with a horizon


def with_seen_limits(
    space: CapturedSpace, center: Triple, up: Triple, *, scene: HybridScene[Floats], cameras: Sequence[Camera]
) -> CapturedSpace:
    """Return the space around `center` with limits to the views that `cameras` saw of the scene; `up` is a unit vector.

    Without limits if most of what surrounds the subject is empty in the cameras' own pictures, and for a sparse rig,
    for which it returns whether viewers begin with the subject alone.
    """
    seen = SeenShare(scene, cameras)
    if space.cones:
        return dataclasses.replace(space, subject_only=seen.twice(SECOND) < ROOM)
    if seen.filled < FILLED:
        return space
    lens = sorted(cameras, key=lambda camera: camera.fx / camera.width)[len(cameras) // 2]
    usual = float(np.median([np.linalg.norm(camera.position - np.array(center)) for camera in cameras]))
    standing = [space.place(camera.position, center, up) for camera in cameras]
    places = [place for place in standing if space.holds(place)]

    def share(place: Place) -> float:
        like = dataclasses.replace(lens, near=lens.near * place.distance / usual)
        return seen.of(view_from(space, place, center, up, like))

    required = min(REQUIRED, float(np.quantile([share(place) for place in places], OWN))) if places else REQUIRED
    return dataclasses.replace(space, seen=limits_where(share, required, space, places))


def limits_where(
    share: Callable[[Place], float], required: float, space: CapturedSpace, places: Sequence[Place]
) -> SeenLimits:
    """Return the limits of the places around the best of each azimuth with a share of at least `required`.

    Where an azimuth or a direction has none, they are the single place with most. `places`, which the space holds, are
    inside in any case.
    """
    half = space.azimuth
    around = np.arange(COLUMNS_ALL_ROUND) / COLUMNS_ALL_ROUND * 2 * math.pi
    azimuths = around if half is None else np.linspace(-half, half, COLUMNS)
    rows, shells = np.linspace(*space.elevation, ROWS), np.geomspace(*space.distance, SHELLS)
    shells[[0, -1]] = space.distance
    found = np.array([[[share(Place(a, e, d)) for d in shells] for e in rows] for a in azimuths])
    elevations = np.array([_range(rows, column.max(axis=1), required) for column in found])
    distances = np.array([[_range(shells, shares, required) for shares in column] for column in found])
    sides = None if half is None else _range(azimuths, found.max(axis=(1, 2)), required)
    for place in places:
        if sides is not None:
            _widen(sides[None], [0], place.azimuth)
        columns, row = _beside(place.azimuth, azimuths, half), _before(place.elevation, rows)
        _widen(elevations, columns, place.elevation)
        for column in columns:
            _widen(distances[column], [row, row + 1], place.distance)
    elevations, distances = _rounded(elevations, space.elevation), _rounded(distances, space.distance)
    return SeenLimits(
        tuple(_pair(one) for one in elevations),
        tuple(tuple(_pair(one) for one in column) for column in distances),
        None if half is None or sides is None else _pair(_rounded(sides, (-half, half))),
    )


def view_from(space: CapturedSpace, place: Place, center: Triple, up: Triple, like: Camera) -> Camera:
    """Return an upright camera at a place, which looks at the centre; all but its pose is `like`'s."""
    direction = space.direction(place.azimuth, min(max(place.elevation, -POLE), POLE), up)
    pose = looking_at(np.array(center) + place.distance * direction, center, up=up)
    return dataclasses.replace(like, world_to_camera=pose, cx=like.width / 2, cy=like.height / 2)


def _range(values: Doubles, shares: Doubles, required: float) -> Doubles:
    """Return the part of ascending values, around that of the largest share, in which the share is large enough.

    Between two values the share is taken to change evenly.
    """
    best = int(shares.argmax())
    if shares[best] < required:
        return values[[best, best]]
    ends = []
    for step, last in ((-1, 0), (1, len(values) - 1)):
        at = best
        while at != last and shares[at + step] >= required:
            at += step
        end = values[at]
        if at != last:
            end += (values[at + step] - end) * (shares[at] - required) / (shares[at] - shares[at + step])
        ends.append(end)
    return np.array(ends)


def _beside(azimuth: float, azimuths: Doubles, half: float | None) -> list[int]:
    """Return the columns on either side of an azimuth."""
    if half is not None:
        first = _before(azimuth, azimuths)
        return [first, first + 1]
    first = math.floor(azimuth / (2 * math.pi) * len(azimuths))
    return [first % len(azimuths), (first + 1) % len(azimuths)]


def _before(value: float, nodes: Doubles) -> int:
    """Return the last node not above a value, but for the last of all."""
    return int(np.clip(np.searchsorted(nodes, value, side="right") - 1, 0, len(nodes) - 2))


def _widen(ranges: Doubles, rows: Sequence[int], value: float) -> None:
    """Make ranges hold a value, in place."""
    ranges[rows, 0] = np.minimum(ranges[rows, 0], value)
    ranges[rows, 1] = np.maximum(ranges[rows, 1], value)


def _rounded(ranges: Doubles, box: Range) -> Doubles:
    """Return ranges [..., 2] with few digits, no narrower, and within the box."""
    digits = DIGITS - math.ceil(math.log10(max(map(abs, box))))
    low, high = np.floor(ranges[..., 0] * 10.0**digits), np.ceil(ranges[..., 1] * 10.0**digits)
    return np.clip(np.round(np.stack([low, high], -1) / 10.0**digits, max(digits, 0)), *box)


def _pair(ends: Doubles) -> Range:
    return float(ends[0]), float(ends[1])
