"""The ways in which the matrices of a rig can be meant: inverted, with other axes, of a left-handed world.

A pose is W = A S B: S is a matrix M or its inverse, A exchanges and turns axes of the camera, B those of the world. A
rotation B moves no camera against another, and every mirror B is one of x and a rotation. So B is nothing
or the mirror of x, whichever leaves no reflection, and 48 axes A times two S are all readings there are. Axes A and -A
have the same epipolar lines: what lies before the cameras with one lies behind them with the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
import numpy.typing as npt

from hgs_core.capture.cameras.rigid_poses import MIRROR

__all__ = ["Reading", "known_axes", "readings", "rotations"]

Floats = npt.NDArray[np.float64]

_AXES = ("right", "down", "forward")
_OPPOSITE = {"right": "left", "down": "up", "forward": "backwards"}


def _signed(order: Sequence[int], signs: Sequence[float]) -> Floats:
    axes = np.eye(4)
    axes[:3, :3] = np.diag(signs) @ np.eye(3)[list(order)]
    return axes


_ALL_AXES = [_signed(*one) for one in product(permutations(range(3)), product((1.0, -1.0), repeat=3))]
"""The 48 ways to exchange and turn axes, the identity first."""


@dataclass(frozen=True)
class Reading:
    """One way in which all matrices are meant."""

    axes: Floats  # [4, 4], A
    inverse: bool
    mirrored: bool  # whether the world is left-handed

    @property
    def usual(self) -> bool:
        """Whether no axes are exchanged, at most turned, or they are a known mix-up."""
        return bool((np.abs(self.axes) == np.eye(4)).all()) or known_axes(self.axes) != ""

    @property
    def cost(self) -> float:
        """Factor of errors: of readings that fit alike, as of a rig in one plane, the simplest is meant."""
        other_axes = not np.array_equal(self.axes, np.eye(4))
        return 1.0 + 0.1 * other_axes + 0.1 * (other_axes and bool(np.linalg.det(self.axes) < 0))

    def poses(self, matrices: Floats) -> Floats:
        """Return the poses [C, 4, 4] that matrices [C, 4, 4] mean."""
        found = self.axes @ (np.linalg.inv(matrices) if self.inverse else matrices)
        return np.asarray(found @ MIRROR if self.mirrored else found)

    def problem(self) -> str:
        """Return the mistake that makes the poses as they are."""
        if self.mirrored and not self.inverse and np.array_equal(self.axes[:3, :3], -np.eye(3)):
            return "the poses have translations of the wrong sign"
        said = ["are inverted (world-to-camera for camera-to-world, or the reverse)"] if self.inverse else []
        if not np.array_equal(self.axes, np.eye(4)):
            read = ", ".join(f"{name} is {_direction(self.axes, number)}" for number, name in enumerate(_AXES))
            said.append(f"have other axes than this layout's: what is read as {read}{known_axes(self.axes)}")
        if self.mirrored:
            said.append("are of a left-handed world, of which x is turned")
        return f"the poses {', and '.join(said)}"

    def cure(self) -> str:
        """Return the cure."""
        if self.mirrored:
            return "export with right-handed axes"
        if self.inverse:
            return "save the inverse of each matrix"
        return "save the poses with the axes of their layout (docs/captures.md)"


def readings(matrices: Floats) -> list[Reading]:
    """Return all readings of matrices [C, 4, 4] of one handedness but the one that leaves them as they are."""
    sign = np.linalg.det(matrices[0, :3, :3])
    every = [
        Reading(axes, inverse, bool(np.linalg.det(axes) * sign < 0)) for axes in _ALL_AXES for inverse in (False, True)
    ]
    return [one for one in every if one.inverse or one.mirrored or not np.array_equal(one.axes, np.eye(4))]


def rotations() -> list[Floats]:
    """Return the 24 rotations [4, 4] that exchange axes, the identity first."""
    return [axes for axes in _ALL_AXES if np.linalg.det(axes) > 0]


def known_axes(axes: Floats) -> str:
    """Return the mix-up that axes [4, 4] come from, in brackets; empty if it is none of the usual."""
    known: dict[tuple[tuple[int, ...], ...], str] = {
        ((1, 0, 0), (0, -1, 0), (0, 0, -1)): "OpenGL's axes for OpenCV's, or the other way round",
        ((0, 1, 0), (1, 0, 0), (0, 0, -1)): "OpenCV's columns in poses_bounds.npy, which has LLFF's",
        ((0, 1, 0), (-1, 0, 0), (0, 0, 1)): "OpenGL's columns in poses_bounds.npy, which has LLFF's",
    }
    words = known.get(tuple(tuple(int(v) for v in row) for row in axes[:3, :3].tolist()))
    return f" ({words})" if words else ""


def _direction(axes: Floats, read: int) -> str:
    """Return in words where the axis that is read as number `read` truly points."""
    true = int(np.abs(axes[:3, read]).argmax())
    return _AXES[true] if axes[true, read] > 0 else _OPPOSITE[_AXES[true]]
