"""Boxes and balls in the world, and which points and paths lie inside them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles, Mask
from hgs_core.base.errors import InputError
from hgs_core.scene.rotations import matrices, unit_quaternions

__all__ = ["Ball", "Box", "Region", "ball_of", "box_of"]


class Region(Protocol):
    """A convex part of the world that has its border."""

    @property
    def name(self) -> str:
        """Its name for people."""

    def contains(self, points: NDArray[np.floating[Any]]) -> Mask:
        """Return which points [..., 3] lie inside or on the border."""

    def holds(self, local: Doubles) -> Mask:
        """Return the same of points in the region's own axes and from its middle."""

    def misses(self, low: Doubles, high: Doubles) -> Mask:
        """Return which boxes along its own axes, with corners [N, 3], surely have nothing in common with it."""

    def local(self, path: Doubles) -> Doubles:
        """Return polynomial paths [..., K, 3], constant first, in the region's own axes and from its middle."""

    def borders(self, path: Doubles) -> list[Doubles]:
        """Return polynomials, constant first, one of which is zero where a local path [K, 3] crosses the border."""


@dataclass(frozen=True, eq=False)
class Box:
    """A box of any direction."""

    center: Doubles  # [3] world units
    size: Doubles  # [3] whole sides, world units, above 0
    axes: Doubles  # [3, 3] its axes in the world, as columns; a rotation
    name = "box"

    def contains(self, points: NDArray[np.floating[Any]]) -> Mask:
        """Return which points [..., 3] lie inside or on the border."""
        return self.holds((np.asarray(points, np.float64) - self.center) @ self.axes)

    def holds(self, local: Doubles) -> Mask:
        """Return the same of points in the box's axes."""
        return np.asarray((np.abs(local) <= self.size / 2).all(axis=-1))

    def misses(self, low: Doubles, high: Doubles) -> Mask:
        """Return which local boxes with corners [N, 3] surely have no point in common with it."""
        return np.asarray(((low > self.size / 2) | (high < -self.size / 2)).any(axis=1))

    def local(self, path: Doubles) -> Doubles:
        """Return polynomial paths [..., K, 3] in the box's axes."""
        found = path.copy()
        found[..., 0, :] -= self.center
        return np.asarray(found @ self.axes)

    def borders(self, path: Doubles) -> list[Doubles]:
        """Return the distances from the six faces along a local path [K, 3]."""
        constant = np.eye(len(path))[0]
        return [path[:, i] - sign * self.size[i] / 2 * constant for i in range(3) for sign in (-1, 1)]


@dataclass(frozen=True, eq=False)
class Ball:
    """Everything within a distance of a point."""

    center: Doubles  # [3] world units
    radius: float  # world units, above 0
    name = "sphere"

    def contains(self, points: NDArray[np.floating[Any]]) -> Mask:
        """Return which points [..., 3] lie inside or on the border."""
        return self.holds(np.asarray(points, np.float64) - self.center)

    def holds(self, local: Doubles) -> Mask:
        """Return the same of points from the middle."""
        return np.asarray(np.linalg.norm(local, axis=-1) <= self.radius)

    def misses(self, low: Doubles, high: Doubles) -> Mask:
        """Return which local boxes with corners [N, 3] surely have no point in common with it."""
        return np.asarray(np.linalg.norm(np.clip(0.0, low, high), axis=1) > self.radius)

    def local(self, path: Doubles) -> Doubles:
        """Return polynomial paths [..., K, 3] from the middle."""
        found = path.copy()
        found[..., 0, :] -= self.center
        return found

    def borders(self, path: Doubles) -> list[Doubles]:
        """Return the squared distance from the middle, less that of the border, along a local path [K, 3]."""
        square = np.sum([np.convolve(axis, axis) for axis in path.T], axis=0)
        square[0] -= self.radius**2
        return [np.asarray(square)]


def box_of(numbers: list[float]) -> Box:
    """Return the box of its middle (3), its sides (3) and, if it is turned, its quaternion w, x, y, z.

    Raises:
        InputError: another count, a side that is not positive, a quaternion of no length.
    """
    if len(numbers) not in (6, 10) or not np.isfinite(numbers).all():
        raise InputError("--box", f"has {len(numbers)} finite numbers", "give x,y,z,width,height,depth[,w,x,y,z]")
    size, quaternion = np.array(numbers[3:6]), np.array(numbers[6:] or [1.0, 0.0, 0.0, 0.0])
    if not (size > 0).all():
        raise InputError("--box", f"a side of {size.min():g} is not positive", "give the whole lengths of its sides")
    if np.linalg.norm(quaternion) < 1e-6:
        raise InputError("--box", "its quaternion has no length", "give w,x,y,z, or leave it out")
    return Box(np.array(numbers[:3]), size, matrices(unit_quaternions(quaternion[None]))[0])


def ball_of(numbers: list[float]) -> Ball:
    """Return the ball of its middle (3) and its radius.

    Raises:
        InputError: another count, or a radius that is not positive.
    """
    if len(numbers) != 4 or not np.isfinite(numbers).all():
        raise InputError("--sphere", f"has {len(numbers)} finite numbers", "give x,y,z,radius")
    if not numbers[3] > 0:
        raise InputError("--sphere", f"a radius of {numbers[3]:g} is not positive", "give world units above 0")
    return Ball(np.array(numbers[:3]), numbers[3])
