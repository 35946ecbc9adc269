"""From where the pictures of a scene were taken, as the manifest tells it (docs/format.md, "Captured space")."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.codec.format.json_fields import Field

__all__ = ["CapturedSpace", "Place"]


@dataclass(frozen=True)
class Place:
    """A point as seen from the scene's centre."""

    azimuth: float  # radians in [-pi, pi], from `front`, counter-clockwise seen from above
    elevation: float  # radians in [-pi/2, pi/2], above the horizon
    distance: float  # world units


@dataclass(frozen=True)
class CapturedSpace:
    """The part of space around a scene's centre from which it can be looked at with trust."""

    front: tuple[float, float, float]  # unit vector at right angles to the scene's `up`: the middle of the azimuths
    azimuth: float | None  # half of the range, radians in (0, pi); None: all round
    elevation: tuple[float, float]  # lowest and highest, radians
    distance: tuple[float, float]  # nearest and farthest, world units, above 0

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

    def holds(self, place: Place) -> bool:
        """Return whether a place is inside."""
        return (
            (self.azimuth is None or abs(place.azimuth) <= self.azimuth)
            and self.elevation[0] <= place.elevation <= self.elevation[1]
            and self.distance[0] <= place.distance <= self.distance[1]
        )

    def to_json(self) -> dict[str, Any]:
        """Return the plain form."""
        document: dict[str, Any] = {"front": list(self.front)}
        if self.azimuth is not None:
            document["azimuth"] = self.azimuth
        return document | {"elevation": list(self.elevation), "distance": list(self.distance)}

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
        low, high = _range(field["elevation"])
        nearest, farthest = _range(field["distance"])
        if nearest <= 0:
            raise field["distance"].error(f"begins at {nearest}, expected above 0")
        return cls((x, y, z), azimuth, (low, high), (nearest, farthest))


def _range(field: Field) -> tuple[float, float]:
    low, high = field.numbers(2)
    if low > high:
        raise field.error(f"is {field.value!r}, expected ascending numbers")
    return low, high
