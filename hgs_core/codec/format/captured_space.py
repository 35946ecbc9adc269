"""From where the pictures of a scene were taken, as the manifest tells it (docs/format.md, "Captured space")."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.codec.format.json_fields import Field
from hgs_core.codec.format.seen_limits import SeenLimits, range_of

__all__ = ["CapturedSpace", "Place"]

Triple = tuple[float, float, float]

UNIT = 1e-3  # deviation of a unit vector's length from 1


@dataclass(frozen=True)
class Place:
    """A point as seen from the scene's centre."""

    azimuth: float  # radians in [-pi, pi], from `front`, counter-clockwise seen from above
    elevation: float  # radians in [-pi/2, pi/2], above the horizon
    distance: float  # world units


@dataclass(frozen=True)
class CapturedSpace:
    """The part of space around a scene's centre from which it can be looked at with trust."""

    front: Triple  # unit vector at right angles to the scene's `up`: the middle of the azimuths
    azimuth: float | None  # half of the range, radians in (0, pi); None: all round
    elevation: tuple[float, float]  # lowest and highest, radians
    distance: tuple[float, float]  # nearest and farthest, world units, above 0
    seen: SeenLimits | None = None  # narrower ranges, direction by direction; None: not known
    cones: tuple[Triple, ...] = ()  # unit vectors from the centre to the cameras of a sparse rig; none: a dense rig
    subject_only: bool = False  # viewers begin without what stands still

    def place(self, point: npt.ArrayLike, center: npt.ArrayLike, up: npt.ArrayLike) -> Place:
        """Return where a point [3] lies around `center` [3], with `up` [3] a unit vector.

        A point on the vertical through the centre has the azimuth 0, the centre itself the elevation 0.
        """
        offset = np.asarray(point, np.float64) - np.asarray(center, np.float64)
        upward, forward = np.asarray(up, np.float64), np.asarray(self.front)
        height = float(offset @ upward)
        ahead = float(offset @ forward)
        aside = float(offset @ np.cross(upward, forward))
        return Place(
            math.atan2(aside, ahead), math.atan2(height, math.hypot(ahead, aside)), float(np.linalg.norm(offset))
        )

    def direction(self, azimuth: float, elevation: float, up: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Return the unit vector [3] from the centre to a place; `up` is a unit vector [3]. The inverse of `place`."""
        upward, forward = np.asarray(up, np.float64), np.asarray(self.front)
        ahead = math.cos(azimuth) * forward + math.sin(azimuth) * np.cross(upward, forward)
        return np.asarray(math.cos(elevation) * ahead + math.sin(elevation) * upward)

    def holds(self, place: Place) -> bool:
        """Return whether a place is inside."""
        left, right = self.azimuths
        if not left <= place.azimuth <= right:
            return False
        low, high = self.elevations(place.azimuth)
        if not low <= place.elevation <= high:
            return False
        nearest, farthest = self.distances(place.azimuth, place.elevation)
        return nearest <= place.distance <= farthest

    @property
    def azimuths(self) -> tuple[float, float]:
        """The range of azimuths; without limits, it has no end."""
        if self.azimuth is None:
            return -math.inf, math.inf
        seen = None if self.seen is None else self.seen.azimuth
        return seen or (-self.azimuth, self.azimuth)

    def elevations(self, azimuth: float) -> tuple[float, float]:
        """Return the lowest and highest elevation at an azimuth."""
        return self.elevation if self.seen is None else self.seen.elevation(azimuth, self.azimuth)

    def distances(self, azimuth: float, elevation: float) -> tuple[float, float]:
        """Return the nearest and farthest distance in a direction."""
        if self.seen is None:
            return self.distance
        return self.seen.distance(azimuth, elevation, self.azimuth, self.elevation)

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        document: dict[str, Any] = {"front": list(self.front)}
        if self.azimuth is not None:
            document["azimuth"] = self.azimuth
        document |= {"elevation": list(self.elevation), "distance": list(self.distance)}
        if self.seen is not None:
            document["seen"] = self.seen.to_json()
        if self.cones:
            document["cones"] = [list(direction) for direction in self.cones]
        if self.subject_only:
            document["subject_only"] = True
        return document

    @classmethod
    def read(cls, field: Field) -> CapturedSpace:
        """Read the plain form.

        Raises:
            InputError: names the field, the value and what it should be.
        """
        x, y, z = field["front"].numbers(3)
        azimuth = field["azimuth"].number(above=0) if "azimuth" in field.mapping() else None
        if azimuth is not None and azimuth >= math.pi:
            raise field["azimuth"].error(
                f"is {azimuth}, expected below pi", "leave it out where cameras stand all round"
            )
        elevation, distance = range_of(field["elevation"]), range_of(field["distance"])
        if distance[0] <= 0:
            raise field["distance"].error(f"begins at {distance[0]}, expected above 0")
        seen = SeenLimits.read(field["seen"], azimuth, elevation, distance) if "seen" in field.mapping() else None
        cones = tuple(map(_direction, field["cones"].items())) if "cones" in field.mapping() else ()
        alone = field["subject_only"].flag() if "subject_only" in field.mapping() else False
        return cls((x, y, z), azimuth, elevation, distance, seen, cones, alone)


def _direction(field: Field) -> Triple:
    x, y, z = field.numbers(3)
    length = math.hypot(x, y, z)
    if abs(length - 1) > UNIT:
        raise field.error(f"has the length {length:g}, expected 1")
    return x, y, z
