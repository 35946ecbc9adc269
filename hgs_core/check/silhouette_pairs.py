"""How well the silhouettes of two cameras agree, as their poses are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.check.epipolar import FAR, Rig
from hgs_core.check.silhouettes import Silhouette

__all__ = ["SilhouettePair", "Silhouettes"]

_FEWEST_MOMENTS = 8  # moments that a pair is judged by

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Silhouettes:
    """The silhouettes of one camera at M moments: of all that moves together, and of each body alone."""

    moments: int
    moment: Ints  # [N] of each silhouette, ascending
    middles: Floats  # [N, 2] pixels
    corners: Floats  # [K, 2] of all, one after the other, pixels
    inside: Bools  # [K] whether the corner lies off the border of the picture
    starts: Ints  # [N] where each silhouette's corners begin

    @classmethod
    def of(cls, shapes: Sequence[Sequence[Silhouette]]) -> Silhouettes:
        """Return those of a list for each moment."""
        every = [(moment, shape) for moment, own in enumerate(shapes) for shape in own]
        counts = [len(shape.corners) for _, shape in every]
        return cls(
            len(shapes),
            np.array([moment for moment, _ in every], np.int64),
            np.array([shape.middle for _, shape in every]).reshape(-1, 2),
            np.concatenate([np.empty((0, 2)), *(shape.corners for _, shape in every)]),
            np.concatenate([np.empty(0, np.bool_), *(shape.inside for _, shape in every)]),
            np.cumsum([0, *counts[:-1]], dtype=np.int64)[: len(every)],
        )

    @property
    def shown(self) -> Bools:
        """Whether something moves at each moment [M]."""
        return np.isin(np.arange(self.moments), self.moment)


@dataclass(frozen=True)
class SilhouettePair:
    """The silhouettes of two cameras, in place of matches."""

    first: Silhouettes
    second: Silhouettes
    later: int = 0  # moments by which the first camera's are moved against the second's

    @property
    def weight(self) -> float:
        """Moments at which both cameras show something that moves."""
        return float((_moved(self.first.shown, self.later) & _moved(self.second.shown, -self.later)).sum())

    @property
    def tells(self) -> bool:
        """Whether there are enough moments to judge poses by."""
        return self.weight >= _FEWEST_MOMENTS

    def error(self, rig: Rig, a: int, b: int) -> float:
        """Return the median distance of epipolar tangents from the other camera's silhouette, pixels."""
        return _on_diagonal(self.distances(rig, a, b), self.later)

    def errors(self, rig: Rig, a: int, b: int, later: Sequence[int]) -> Floats:
        """Return `error` for several moves [L] of the first camera's moments; NaN where too few moments are left."""
        distances = self.distances(rig, a, b)
        pairs = [SilhouettePair(self.first, self.second, one) for one in later]
        return np.array([_on_diagonal(distances, one.later) if one.tells else np.nan for one in pairs])

    def distances(self, rig: Rig, a: int, b: int) -> Floats:
        """Return the distance [M, M] between each moment of the first and each of the second, NaN if neither tells.

        The two planes through both cameras that touch a body touch its silhouette in both pictures (frontier points:
        Cipolla & Giblin, Visual Motion of Curves and Surfaces, 2000). Not every body is in both pictures: that counts
        which fits best, of all together and each alone. Where the rays through the middles part in front of the
        cameras, it is `FAR`.
        """
        count = self.first.moments, self.second.moments
        centres = rig.centres()
        apart = centres[b] - centres[a]
        length = float(np.linalg.norm(apart))
        if length <= 1e-12 * float(np.abs(centres).max() + 1e-300):
            return np.full(count, FAR)
        axis = apart / length
        across = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
        across /= np.linalg.norm(across)
        frame = np.array((axis, across, np.cross(axis, across)))
        between = _tangent_distances(_seen(self.first, rig, a, frame), _seen(self.second, rig, b, frame))
        found = np.full(count, np.inf)
        np.minimum.at(found, (self.first.moment[:, None], self.second.moment[None]), between)
        return np.where(np.isinf(found), np.nan, found)


@dataclass(frozen=True)
class _Seen:
    """N silhouettes of a camera by the half planes about the line through two cameras."""

    turn: Floats  # [N] angle of the half plane through the middle
    low: Floats  # [N] angles of the two tangent half planes, from there
    high: Floats
    low_inside: Bools  # [N]
    high_inside: Bools
    from_axis: Floats  # [N] angle between the line and the ray through the middle
    pixels: Floats  # [N] motion of the middle with a turn of one radian


def _seen(shapes: Silhouettes, rig: Rig, camera: int, frame: Floats) -> _Seen:
    k = rig.intrinsics[camera]
    points = np.vstack((shapes.middles, shapes.corners))
    rays = np.column_stack(((points - k[:2, 2]) / np.diag(k)[:2], np.ones(len(points)))) @ rig.poses[camera, :3, :3]
    along, one, other = (rays / np.linalg.norm(rays, axis=1, keepdims=True) @ frame.T).T
    turns, count = np.arctan2(other, one), len(shapes.middles)
    of = np.repeat(np.arange(count), np.diff(np.append(shapes.starts, len(shapes.corners))))
    from_middle = _wrapped(turns[count:] - turns[:count][of])
    angle = np.arccos(np.clip(along[:count], -1, 1))
    pixels = np.sqrt(k[0, 0] * k[1, 1]) * np.sin(angle)
    if not count:
        return _Seen(angle, angle, angle, angle > 0, angle > 0, angle, pixels)
    low, high = (extreme.reduceat(from_middle, shapes.starts) for extreme in (np.minimum, np.maximum))
    held = [
        np.logical_or.reduceat(shapes.inside & (from_middle == extreme[of]), shapes.starts) for extreme in (low, high)
    ]
    return _Seen(turns[:count], low, high, held[0], held[1], angle, pixels)


def _tangent_distances(one: _Seen, other: _Seen) -> Floats:
    """Return the mean distance [N, N'] of the tangents that both pictures hold, pixels; infinity if they hold none."""
    turned = _wrapped(other.turn - one.turn[:, None])
    low = one.low_inside[:, None] & other.low_inside
    high = one.high_inside[:, None] & other.high_inside
    sums = low * np.abs(turned + other.low - one.low[:, None]) + high * np.abs(turned + other.high - one.high[:, None])
    held = low.astype(np.int64) + high
    distance = np.minimum(FAR, sums / np.maximum(held, 1) * (one.pixels[:, None] + other.pixels) / 2)
    distance[one.from_axis[:, None] >= other.from_axis] = FAR
    return np.where(held > 0, distance, np.inf)


def _on_diagonal(distances: Floats, later: int) -> float:
    """Return the median for the moments of the first camera `later` than the second's; 0 where none tells."""
    told = np.diagonal(distances, -later)
    told = told[~np.isnan(told)]
    return float(np.median(told)) if len(told) else 0.0


def _moved(shown: Bools, later: int) -> Bools:
    return shown[later:] if later > 0 else shown[: len(shown) + later]


def _wrapped(angles: Floats) -> Floats:
    return np.asarray((angles + np.pi) % (2 * np.pi) - np.pi)
