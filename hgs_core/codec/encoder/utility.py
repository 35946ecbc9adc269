"""How much a splat shows, and how finely its numbers are therefore worth storing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.scene.camera import Camera
from hgs_core.scene.low_pass import LOW_PASS

__all__ = ["GRADES", "SetUtility", "Utility", "estimated_utility", "grades", "pixels_per_unit"]

GRADES = (-4, 3)  # smallest and largest; a grade is a factor of 2 in the width of steps
GUESSED_TRANSMITTANCE = 0.5  # transmittance before a splat without measurements


@dataclass(frozen=True)
class SetUtility:
    """The utility of each splat of a set: its effect on the capture's pictures, means over the views.

    `shown` is what the squared error of the picture grows by for a unit error of the splat's colour (a channel),
    `missed` what it grows by (all three channels) if this splat alone is left out and what lies behind it shows;
    infinity for a splat that must not be.
    """

    shown: Doubles  # [N] sum_pixels (T alpha)^2, pixels
    missed: Doubles  # [N] sum_pixels |T alpha (colour - colour behind)|^2

    def take(self, index: NDArray[Any]) -> SetUtility:
        """Return the utility of the splats that `index` selects."""
        return SetUtility(self.shown[index], self.missed[index])


@dataclass(frozen=True)
class Utility:
    """The utility of the splats of a scene."""

    static: SetUtility
    dynamic: tuple[SetUtility, ...]  # one for each segment, over all views of the whole scene


def pixels_per_unit(points: Doubles, cameras: Sequence[Camera]) -> Doubles:
    """Return the pixels of a world unit at each of `points` [N, 3]: root mean square over the cameras that see it, [N].

    A point in no camera's picture has what it would fill in that of the nearest one.
    """
    squares, seen, nearest = np.zeros(len(points)), np.zeros(len(points)), np.zeros(len(points))
    for camera in cameras:
        pixels, depth = camera.project(points)
        inside = camera.shows(pixels, depth)
        squares[inside] += camera.fx * camera.fy / depth[inside] ** 2
        seen += inside
        distance = np.maximum(np.linalg.norm(points - camera.position, axis=1), camera.near)
        nearest = np.maximum(nearest, (camera.fx * camera.fy) ** 0.5 / distance)
    return np.where(seen > 0, np.sqrt(squares / np.maximum(seen, 1)), nearest)


def estimated_utility(log_scales: Doubles, opacity: Doubles, scale: Doubles, shown: Doubles | float = 1.0) -> Doubles:
    """Guess the utility [N] of splats that were not measured, from size, opacity [N] and the share of time shown.

    The squared alpha of a Gaussian with standard deviations a and b pixels adds up to pi a b sigma^2.
    """
    largest = np.sort(np.exp(2 * log_scales) * scale[:, None] ** 2 + LOW_PASS, axis=1)[:, 1:]
    area = np.sqrt(np.minimum(largest, 1e4).prod(axis=1))
    return np.asarray(np.pi * area * (GUESSED_TRANSMITTANCE * opacity) ** 2 * shown)


def grades(utility: Doubles) -> NDArray[np.int64]:
    """Return the grade [N] of splats: log2 of the square root of their utility, rounded and limited to `GRADES`."""
    with np.errstate(divide="ignore"):
        return np.clip(np.rint(np.log2(utility) / 2), *GRADES).astype(np.int64)
