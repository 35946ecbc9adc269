"""Plane sweep: the depth at which a picture agrees best with its neighbours (Collins, CVPR 1996), on a grid of pixels.

Features alone leave blank walls and wide baselines without points. The sweep gives every part of every picture a
depth, and says by the agreement of the neighbours' own depths how far each one can be trusted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.points.depth_map import DepthMap, GivenDepth, SweptPoints, no_depth, points_of_maps, with_known
from hgs_core.points.sweep_costs import BLIND_COST, colour_descriptors, sweep_costs
from hgs_core.points.visibility import nearest_cameras, pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["depth_ranges", "sweep"]

_DEPTHS = 64
_NEIGHBOUR_VIEWS = 4  # views that a picture is compared with, of which one may be blocked
_AGREEMENT = 0.03  # share of the depth; views that differ by less see the same surface
_BEYOND = 1.2  # times the depth; a view of anything farther sees through the point
_FEW_POINTS = 20  # points below which a camera's depth range is taken from all points
_NEAREST = 0.5  # share of the median distance to neighbour views; nearer things look too different there


def depth_ranges(cameras: Sequence[Camera], xyz: npt.NDArray[np.floating[Any]]) -> list[tuple[float, float]]:
    """Return each camera's nearest and farthest depth of interest, from known points [P, 3] with some room.

    Without points the cameras' spacing has to do: from one to thirty times the mean distance to their centre.
    No range starts nearer than half as far as the views are away that a picture is compared with, unless it ends there
    or soon after. Cameras around a scene film each other, and a point on a camera's own lens, which it cannot see,
    would leave all that it can see to steps that miss it.
    """
    around = nearest_cameras(cameras, _NEIGHBOUR_VIEWS)
    positions = np.array([camera.position for camera in cameras])
    extent = float(np.linalg.norm(positions - positions.mean(axis=0), axis=1).mean()) or 1.0
    ranges = []
    for camera, others in zip(cameras, around, strict=True):
        rows, _ = pixels_inside(camera, xyz)
        _, depths = camera.project(xyz[rows] if len(rows) >= _FEW_POINTS else xyz)
        depths = depths[depths > 0]
        if len(depths) < _FEW_POINTS:
            ranges.append((0.3 * extent, 10.0 * extent))
        else:
            near, far = (float(depth) for depth in np.percentile(depths, (1, 99)) * (0.7, 1.4))
            apart = np.linalg.norm(positions[others] - camera.position, axis=1)
            least = _NEAREST * float(np.median(apart)) if len(apart) else 0.0
            ranges.append((max(near, min(least, far / 2)), far))
    return ranges


def sweep(
    cameras: Sequence[Camera],
    pictures: Sequence[npt.NDArray[np.uint8]],  # [H, W, 3] each
    wanted: Sequence[npt.NDArray[np.bool_]],  # [H, W] each: the pixels that need points
    ranges: Sequence[tuple[float, float]],  # nearest and farthest depth of each camera
    rays: int,  # about how many pixels to sweep, over all pictures
    hull: Sequence[npt.NDArray[np.bool_]] = (),  # [H, W] each: three quarters of the views must be set; none: anywhere
    known: GivenDepth = no_depth,
) -> SweptPoints:
    """Return the points that the wanted pixels show; the same bits for any number of threads.

    Where a depth is `known`, it takes the place of the found one.

    A single picture shows none: there is nothing that it could agree with.
    """
    area = sum(int(mask.sum()) for mask in wanted)
    step = max(2, int(np.sqrt(area / max(rays, 1))))
    neighbours = nearest_cameras(cameras, _NEIGHBOUR_VIEWS)

    grid = (slice(step // 2, None, step),) * 2
    given = [None if depths is None else depths[grid].copy() for depths in map(known, range(len(cameras)), cameras)]

    def one(view: int) -> DepthMap:
        others = [(cameras[other], descriptors[other]) for other in neighbours[view]]
        found = _depth_map(cameras[view], descriptors[view], others, wanted[view], ranges[view], step, masks)
        return with_known(found, given[view], ~wanted[view][grid])

    masks = [(c, np.ascontiguousarray(mask)) for c, mask in zip(cameras, hull, strict=True)] if hull else []
    with core_pool() as pool:
        descriptors = list(pool.map(colour_descriptors, pictures))
        maps = list(pool.map(one, range(len(cameras))))
    return points_of_maps(cameras, pictures, maps, agreement=_AGREEMENT, beyond=_BEYOND)


def _depth_map(
    camera: Camera,
    descriptors: npt.NDArray[np.uint8],  # [H W, 6] of the picture that is swept
    neighbours: Sequence[tuple[Camera, npt.NDArray[np.uint8]]],
    wanted: npt.NDArray[np.bool_],
    depth_range: tuple[float, float],
    step: int,
    hull: Sequence[tuple[Camera, npt.NDArray[np.bool_]]],
) -> DepthMap:
    rows, columns = np.arange(step // 2, camera.height, step), np.arange(step // 2, camera.width, step)
    chosen = wanted[np.ix_(rows, columns)]  # [h, w]
    i, j = np.nonzero(chosen)
    found = DepthMap(step, np.zeros(chosen.shape))
    if len(i) == 0 or len(neighbours) == 0:
        return found
    near, far = depth_range
    depths = 1.0 / np.linspace(1.0 / near, 1.0 / far, _DEPTHS)  # evenly in the pixels that a step moves
    rays = camera.rays(np.stack([columns[j] + 0.5, rows[i] + 0.5], 1))
    own = descriptors[rows[i] * camera.width + columns[j]]  # [R, 6]
    cost = _aggregate(sweep_costs(camera, rays, own, depths, neighbours, hull), i, j, chosen)
    best = cost.argmin(axis=1)
    seen = cost[np.arange(len(best)), best] < BLIND_COST
    found.depths[i[seen], j[seen]] = _refine(cost, best, near, far)[seen]
    return found


def _aggregate(
    cost: npt.NDArray[np.float32],  # [R, D]
    i: npt.NDArray[np.int64],
    j: npt.NDArray[np.int64],
    chosen: npt.NDArray[np.bool_],  # [h, w]
) -> npt.NDArray[np.float32]:
    """Average the costs of each grid pixel and its chosen neighbours: a blank pixel borrows the depth of its edge."""
    none = len(cost)  # the row of a neighbour that was not chosen, which is all zero
    row_of = np.full((chosen.shape[0] + 2, chosen.shape[1] + 2), none)
    row_of[i + 1, j + 1] = np.arange(none)
    finite = np.where(np.isfinite(cost), cost, np.float32(2 * BLIND_COST))
    padded = np.concatenate((finite, np.zeros((1, cost.shape[1]), np.float32)))
    total, weight = finite * 2, np.full(none, 2, np.float32)  # the pixel itself counts three times
    for down in (0, 1, 2):
        for right in (0, 1, 2):
            neighbour = row_of[i + down, j + right]
            total += padded[neighbour]
            weight += neighbour < none
    return np.where(np.isfinite(cost), total / weight[:, None], np.float32(np.inf))


def _refine(
    cost: npt.NDArray[np.float32], best: npt.NDArray[np.int64], near: float, far: float
) -> npt.NDArray[np.float64]:
    """Return the depth at the vertex of the parabola through the lowest cost and its two neighbours."""
    rows = np.arange(len(best))
    inner = np.clip(best, 1, cost.shape[1] - 2)
    left, middle, right = (cost[rows, inner + shift].astype(np.float64) for shift in (-1, 0, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        shift = 0.5 * (left - right) / (left - 2 * middle + right)
    shift = np.where((inner == best) & np.isfinite(shift), np.clip(shift, -0.5, 0.5), 0.0)
    inverse = 1.0 / near + (best + shift) * (1.0 / far - 1.0 / near) / (cost.shape[1] - 1)
    return np.asarray(1.0 / inverse)
