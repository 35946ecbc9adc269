"""The pinhole camera that every part of HGS shares."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError

__all__ = ["FAR_APART", "ORTHONORMAL", "Camera", "is_orthonormal", "looking_at", "neighbour_angle"]

FAR_APART = math.radians(40)
"""Median angle to the next camera, from which on each alone sees its side of a subject: features are lost near 30."""

ORTHONORMAL = 1e-3
"""Tolerance on the products of a rotation's rows."""


@dataclass(frozen=True, eq=False)
class Camera:
    """An undistorted pinhole camera in the OpenCV convention: x right, y down, z forward.

    Pixel centres lie at +0.5: the world point x projects to (fx X/Z + cx, fy Y/Z + cy) with
    (X, Y, Z) = R x + t, and pixel (column j, row i) covers [j, j + 1) x [i, i + 1).
    """

    name: str
    width: int  # pixels
    height: int  # pixels
    fx: float  # pixels
    fy: float  # pixels
    cx: float  # pixels
    cy: float  # pixels
    world_to_camera: npt.NDArray[np.float64]  # [4, 4], rigid, right-handed, metres where the capture knows them
    near: float = 0.01  # world units; what is nearer is not drawn

    def __post_init__(self) -> None:
        """Refuse numbers that are not a camera.

        Raises:
            InputError: a non-positive size or focal length, or a pose that is not a rotation and a translation.
        """
        pose = np.asarray(self.world_to_camera, dtype=np.float64)
        object.__setattr__(self, "world_to_camera", pose)
        where = f"camera {self.name}"
        if self.width < 1 or self.height < 1:
            raise InputError(where, f"image size {self.width}x{self.height} is not positive")
        if not self.near > 0:
            raise InputError(where, f"near plane {self.near} is not positive")
        if not (self.fx > 0 and self.fy > 0):
            raise InputError(where, f"focal length ({self.fx}, {self.fy}) is not positive")
        if pose.shape != (4, 4) or not np.isfinite(pose).all():
            raise InputError(where, "world_to_camera is not a finite 4x4 matrix")
        if not is_orthonormal(pose[:3, :3]):
            raise InputError(where, "the rotation of world_to_camera is not orthonormal")
        if np.linalg.det(pose[:3, :3]) < 0:
            raise InputError(where, "world_to_camera is a reflection", "check the axis convention of the poses")

    @property
    def position(self) -> npt.NDArray[np.float64]:
        """Camera centre in the world, [3]."""
        return -self.world_to_camera[:3, :3].T @ self.world_to_camera[:3, 3]

    def scaled(self, factor: float) -> Camera:
        """Return the camera of the image resized by `factor`, its sides rounded to whole pixels (at least 1)."""
        width = max(1, round(self.width * factor))
        height = max(1, round(self.height * factor))
        sx, sy = width / self.width, height / self.height
        return dataclasses.replace(
            self,
            width=width,
            height=height,
            fx=self.fx * sx,
            fy=self.fy * sy,
            cx=self.cx * sx,
            cy=self.cy * sy,
        )

    def within(self, side: int) -> Camera:
        """Return the camera of the image reduced by a whole factor, to sides of at most `side` pixels."""
        return self.scaled(1 / -(-max(self.width, self.height) // side))

    def project(self, points: npt.NDArray[np.floating[Any]]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Project world points [N, 3] to pixels [N, 2] and depths [N]; pixels are meaningless where depth <= 0."""
        # Rows of all x, all y and all z: numpy is slow where the last axis has two or three numbers.
        local = self.world_to_camera[:3, :3] @ np.asarray(points, np.float64).T + self.world_to_camera[:3, 3:]
        depth = local[2]
        with np.errstate(divide="ignore", invalid="ignore"):
            pixels = local[:2] / depth * ((self.fx,), (self.fy,)) + ((self.cx,), (self.cy,))
        return pixels.T, depth

    def shows(
        self,
        pixels: npt.NDArray[np.floating[Any]],
        depths: npt.NDArray[np.floating[Any]],
        *,
        beyond: float | None = None,
        beside: float = 0.0,
    ) -> npt.NDArray[np.bool_]:
        """Return which projected points [N] lie in the picture.

        Args:
            pixels: [N, 2] of `project`.
            depths: [N] of `project`.
            beyond: depth that a point must exceed, world units; default: the near plane.
            beside: share of the picture's sides, around the picture, in which points count as well.
        """
        column, row = pixels.T
        across, down = beside * self.width, beside * self.height
        with np.errstate(invalid="ignore"):
            return np.asarray(
                (depths > (self.near if beyond is None else beyond))
                & (column >= -across)
                & (column < self.width + across)
                & (row >= -down)
                & (row < self.height + down)
            )

    def rays(self, pixels: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.float64]:
        """Return the vectors [N, 3], in the world, from the camera centre to unit depth behind pixels [N, 2]."""
        local = (np.asarray(pixels, np.float64) - (self.cx, self.cy)) / (self.fx, self.fy)
        return np.concatenate([local, np.ones((len(local), 1))], 1) @ self.world_to_camera[:3, :3]

    def to_json(self) -> dict[str, Any]:
        """Return the plain form that manifests and checkpoints store."""
        return {
            "name": self.name,
            "width": self.width,
            "height": self.height,
            "fx": self.fx,
            "fy": self.fy,
            "cx": self.cx,
            "cy": self.cy,
            "near": self.near,
            "world_to_camera": [[float(x) for x in row] for row in self.world_to_camera],
        }

    @classmethod
    def from_json(cls, value: dict[str, Any]) -> Camera:
        """Read the form that `to_json` wrote.

        Raises:
            InputError: a missing field or one of the wrong type.
        """
        try:
            return cls(
                name=str(value["name"]),
                width=int(value["width"]),
                height=int(value["height"]),
                fx=float(value["fx"]),
                fy=float(value["fy"]),
                cx=float(value["cx"]),
                cy=float(value["cy"]),
                world_to_camera=np.array(value["world_to_camera"], dtype=np.float64),
                near=float(value["near"]),
            )
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError("camera", f"unreadable: {error!r}") from error


def is_orthonormal(turn: npt.NDArray[np.float64]) -> bool:
    """Return whether the rows of a matrix [3, 3] are of length one and at right angles, as a reflection's are, too."""
    # Products of larger numbers may overflow.
    return bool(np.abs(turn).max() <= 2 and np.allclose(turn @ turn.T, np.eye(3), atol=ORTHONORMAL))


def looking_at(
    position: npt.ArrayLike,
    target: npt.ArrayLike,
    roll: float = 0.0,
    *,
    up: npt.ArrayLike = (0.0, -1.0, 0.0),
) -> npt.NDArray[np.float64]:
    """Return the world-to-camera pose [4, 4] of a camera at a point that looks at another.

    Args:
        position: of the camera, [3].
        target: what it looks at, [3]; neither straight above nor straight below the camera.
        roll: radians by which its picture turns about its middle.
        up: upward direction of the world, [3], of any length.
    """
    place = np.asarray(position, np.float64)
    forward = np.asarray(target, np.float64) - place
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, np.asarray(up, np.float64))
    right /= np.linalg.norm(right)
    down = np.cross(forward, right)
    pose = np.eye(4)
    pose[:3, :3] = [
        np.cos(roll) * right + np.sin(roll) * down,
        np.cos(roll) * down - np.sin(roll) * right,
        forward,
    ]
    pose[:3, 3] = -pose[:3, :3] @ place
    return pose


def neighbour_angle(directions: npt.NDArray[np.float64]) -> float:
    """Return the median angle from a direction [N, 3] to the nearest other one, radians; 0 for a single direction."""
    if len(directions) < 2:
        return 0.0
    cosines = directions @ directions.T
    np.fill_diagonal(cosines, -1)
    angles = np.arccos(np.clip(cosines.max(axis=1), -1, 1))
    return float(np.median(angles))
