"""How far matches lie from the epipolar lines of given poses."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from hgs_core.points.matching import PairMatches
from hgs_core.scene.camera import Camera

__all__ = [
    "FAR",
    "Compared",
    "ComparedPairs",
    "Pair",
    "Pairs",
    "Rig",
    "camera_errors",
    "pair_errors",
    "sampson_distances",
    "signed_distances",
]

FAR = 1000.0  # pixels: what an epipolar line that does not exist is away
_NOTHING = 1e-12  # share of the cameras' distance from the origin
_ENOUGH = 150  # matches of a pair; more tell nothing new
_CLEAR = float(np.cos(np.radians(1.0)))  # least angle between rays, one degree: the place where they meet is clear then
_TELLING = 12  # matches with such rays, and ...
_MOST = 0.6  # ... share of them

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Rig:
    """C cameras as matrices, which a hypothesis can change."""

    intrinsics: Floats  # [C, 3, 3]
    poses: Floats  # [C, 4, 4] world-to-camera

    @classmethod
    def of(cls, cameras: Sequence[Camera]) -> Rig:
        """Return the matrices of cameras."""
        k = [[[one.fx, 0, one.cx], [0, one.fy, one.cy], [0, 0, 1]] for one in cameras]
        return cls(np.array(k, np.float64), np.array([one.world_to_camera for one in cameras]))

    @property
    def mirrored(self) -> bool:
        """Whether the poses are reflections: of all cameras or of none."""
        return bool(np.linalg.det(self.poses[0, :3, :3]) < 0)

    def with_pose(self, camera: int, pose: Floats) -> Rig:
        """Return the rig with another pose [4, 4] of one camera."""
        poses = self.poses.copy()
        poses[camera] = pose
        return dataclasses.replace(self, poses=poses)

    def with_focal(self, factor: float, camera: int | None = None) -> Rig:
        """Return the rig with the focal lengths of one camera, or of all, times `factor`."""
        intrinsics = self.intrinsics.copy()
        chosen = slice(None) if camera is None else slice(camera, camera + 1)
        intrinsics[chosen, :2, :2] *= factor
        return dataclasses.replace(self, intrinsics=intrinsics)

    def rearranged(self, order: Sequence[int]) -> Rig:
        """Return the rig with the calibration of camera `order[i]` in each camera i."""
        return Rig(self.intrinsics[list(order)], self.poses[list(order)])

    def centres(self) -> Floats:
        """Return where the cameras stand, [C, 3]."""
        return np.asarray(-np.einsum("cij,ci->cj", self.poses[:, :3, :3], self.poses[:, :3, 3]))

    def fundamental(self, a: int, b: int) -> Floats:
        """Return F [3, 3] with x_b^T F x_a = 0 (Hartley & Zisserman 9.6)."""
        turn = self.poses[b, :3, :3] @ self.poses[a, :3, :3].T
        apart = self.poses[b, :3, 3] - turn @ self.poses[a, :3, 3]
        if np.linalg.norm(apart) <= _NOTHING * np.linalg.norm(self.poses[(a, b), :3, 3]):
            return np.zeros((3, 3))  # one place: rounding gives no direction
        x, y, z = apart
        essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ turn
        return np.asarray(np.linalg.inv(self.intrinsics[b]).T @ essential @ np.linalg.inv(self.intrinsics[a]))


@dataclass(frozen=True)
class Pair:
    """Matches of two cameras, thinned out."""

    first: Floats  # [M, 2] pixels
    second: Floats  # [M, 2]
    weight: float  # matches before

    @classmethod
    def of(cls, matches: PairMatches) -> Pair:
        """Return at most 150 of the matches, evenly chosen."""
        count = len(matches.first)
        rows = np.unique(np.linspace(0, count - 1, min(count, _ENOUGH)).round().astype(int))
        return cls(matches.first[rows], matches.second[rows], float(count))

    def error(self, rig: Rig, a: int, b: int) -> float:
        """Return the median distance from the epipolar lines, pixels; `FAR` where most rays meet behind a camera."""
        return FAR if _behind(rig, a, b, self) else float(np.median(sampson_distances(rig, a, b, self)))


class Compared(Protocol):
    """The evidence of two cameras by which poses can be judged."""

    @property
    def weight(self) -> float:
        """Number of things compared."""

    def error(self, rig: Rig, a: int, b: int) -> float:
        """Return how far it lies from where the poses say, pixels."""


Pairs = Mapping[tuple[int, int], Pair]
ComparedPairs = Mapping[tuple[int, int], Compared]


def signed_distances(fundamental: Floats, first: Floats, second: Floats) -> Floats:
    """Return the Sampson distance of each match [M] with the sign of the side of the line, pixels."""
    x1, x2 = np.column_stack((first, np.ones(len(first)))), np.column_stack((second, np.ones(len(second))))
    lines2, lines1 = x1 @ fundamental.T, x2 @ fundamental
    slope = np.sqrt((lines2[:, :2] ** 2).sum(axis=1) + (lines1[:, :2] ** 2).sum(axis=1))
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (lines2 * x2).sum(axis=1) / slope
    return np.where(np.isfinite(distance), np.clip(distance, -FAR, FAR), FAR)


def sampson_distances(rig: Rig, a: int, b: int, pair: Pair) -> Floats:
    """Return how far each match [M] of cameras a and b lies from its epipolar lines, pixels."""
    return np.abs(signed_distances(rig.fundamental(a, b), pair.first, pair.second))


def _behind(rig: Rig, a: int, b: int, pair: Pair) -> bool:
    """Whether most rays of matches that meet at a clear angle do so behind a camera: epipolar lines do not tell."""
    rays = []
    for camera, pixels in ((a, pair.first), (b, pair.second)):
        k = rig.intrinsics[camera]
        local = np.column_stack(((pixels - k[:2, 2]) / np.diag(k)[:2], np.ones(len(pixels))))
        rays.append(local / np.linalg.norm(local, axis=1, keepdims=True) @ rig.poses[camera, :3, :3])
    first, second = rays
    centres = rig.centres()
    apart = centres[b] - centres[a]
    cosine, along, back = (first * second).sum(axis=1), first @ apart, second @ apart
    clear = cosine < _CLEAR  # s first - t second = apart, multiplied with 1 - cosine^2
    before = (along - back * cosine > 0) & (along * cosine - back > 0)
    return bool(clear.sum() >= _TELLING and (~before[clear]).mean() > _MOST)


def pair_errors(rig: Rig, pairs: ComparedPairs) -> dict[tuple[int, int], float]:
    """Return the median distance of every pair, pixels."""
    return {(a, b): pair.error(rig, a, b) for (a, b), pair in pairs.items()}


def camera_errors(count: int, errors: Mapping[tuple[int, int], float], pairs: ComparedPairs) -> list[float | None]:
    """Return for each camera the weighted median over its pairs, pixels; None for a camera without any."""
    return [
        _weighted_median([(e, pairs[p].weight) for p, e in errors.items() if camera in p]) for camera in range(count)
    ]


def _weighted_median(values: list[tuple[float, float]]) -> float | None:
    if not values:
        return None
    ordered = sorted(values)
    reached = np.cumsum([weight for _, weight in ordered])
    return ordered[int(np.searchsorted(reached, reached[-1] / 2))][0]
