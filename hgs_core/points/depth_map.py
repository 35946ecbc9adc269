"""Depth maps of pictures, and their points with the votes of other pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["DepthMap", "GivenDepth", "SweptPoints", "no_depth", "points_of_maps", "with_known"]

GivenDepth = Callable[[int, Camera], npt.NDArray[np.float32] | None]
"""Known depths [H, W] of the picture of a place among the cameras, at the size of a camera; 0 or None: none known."""


@dataclass(frozen=True)
class SweptPoints:
    """P points, one per grid pixel that found a depth."""

    xyz: npt.NDArray[np.float32]  # [P, 3]
    rgb: npt.NDArray[np.float32]  # [P, 3] in [0, 1]
    agreeing: npt.NDArray[np.int64]  # [P] other views whose own depth agrees
    opposed: npt.NDArray[np.int64]  # [P] other views that see something behind the point, as if it were not there
    facing: npt.NDArray[np.int64]  # [P] other views whose pictures the point falls in

    def take(self, rows: npt.NDArray[np.int64] | npt.NDArray[np.bool_]) -> SweptPoints:
        """Return the points of these rows, or of those where a mask is set."""
        return SweptPoints(self.xyz[rows], self.rgb[rows], self.agreeing[rows], self.opposed[rows], self.facing[rows])


@dataclass(frozen=True)
class DepthMap:
    """Depths on a grid of pixels (top + step i, left + step j) of one picture; 0 where there is none."""

    step: int
    depths: npt.NDArray[np.float64]  # [h, w]


def no_depth(view: int, size: Camera) -> None:
    """Return no depths."""


def with_known(found: DepthMap, known: npt.NDArray[np.float32] | None, left_out: npt.NDArray[np.bool_]) -> DepthMap:
    """Return a map with known depths [h, w] in place of its own, but for the pixels left out."""
    if known is None:
        return found
    return DepthMap(found.step, np.where((known > 0) & ~left_out, known.astype(np.float64), found.depths))


def points_of_maps(
    cameras: Sequence[Camera],
    pictures: Sequence[npt.NDArray[np.uint8]],  # [H, W, 3] each
    maps: Sequence[DepthMap],  # one of each picture
    *,
    agreement: float,
    beyond: float,
) -> SweptPoints:
    """Return the points of all views, those of the first first.

    Views whose depths differ by less than the share `agreement` of the depth see the same surface; one that sees
    something farther than `beyond` times the depth of a point sees through it.
    """

    def of_view(view: int) -> tuple[npt.NDArray[Any], ...]:
        return _points(view, cameras, pictures[view], maps, agreement, beyond)

    with core_pool() as pool:
        parts = list(pool.map(of_view, range(len(cameras))))
    return SweptPoints(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _points(
    view: int,
    cameras: Sequence[Camera],
    picture: npt.NDArray[np.uint8],
    maps: Sequence[DepthMap],
    agreement: float,
    beyond: float,
) -> tuple[npt.NDArray[Any], ...]:
    """Return the points of one view, with the votes of the other views' depths."""
    camera, found = cameras[view], maps[view]
    i, j = np.nonzero(found.depths)
    row, column = i * found.step + found.step // 2, j * found.step + found.step // 2
    xyz = camera.position + camera.rays(np.stack([column + 0.5, row + 0.5], 1)) * found.depths[i, j, None]
    agreeing, opposed, facing = np.zeros((3, len(xyz)), np.int64)
    for other in range(len(cameras)):
        if other == view:
            continue
        rows, pixels = pixels_inside(cameras[other], xyz)
        _, depths = cameras[other].project(xyz[rows])
        cell = np.minimum(pixels // maps[other].step, np.array(maps[other].depths.shape)[::-1] - 1)
        theirs = maps[other].depths[cell[:, 1], cell[:, 0]]  # 0, which is neither, where there is none
        agreeing[rows] += np.abs(theirs - depths) < agreement * depths
        opposed[rows] += theirs > beyond * depths
        facing[rows] += 1
    rgb = picture[row, column].astype(np.float32) / np.float32(255)
    return xyz.astype(np.float32), rgb, agreeing, opposed, facing
