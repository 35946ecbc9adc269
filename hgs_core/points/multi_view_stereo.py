"""Multi-view stereo: a depth for every pixel of every picture, and the points that several pictures agree on.

Walls that are blank but for a few dots have depths, too: what a blank pixel cannot say its neighbours tell it, as far
as there are no edges (`hgs_core.native.plane_sweep`). What several pictures find at the same place is a surface. The
rest is completed from there, and again only that counts in which several pictures agree. Where one camera looks alone,
its surfaces go on as they were completed: without any points there, training makes fog that other cameras would see.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.capture.pictures.picture import reduced_mask, reduced_picture
from hgs_core.native.plane_sweep import plane_sweep
from hgs_core.points.depth_completion import completed
from hgs_core.points.depth_map import DepthMap, GivenDepth, SweptPoints, no_depth, points_of_maps, with_known
from hgs_core.points.visibility import nearest_cameras
from hgs_core.scene.camera import Camera

__all__ = ["multi_view_stereo"]

_NEIGHBOUR_VIEWS = 8  # views that a picture is compared with: the three that fit best at a depth count
_AGREEMENT = 0.015  # share of the depth; views that differ by less see the same surface
_BEYOND = 1.06  # times the depth; a view of anything farther sees through the point
_AGREEING_SHARE = 1 / 3  # share of other views with the point in their pictures; others may be blocked
_AGREEING_VIEWS = 2  # least number, if there are so many
_AGREEING_FOR_ONE_OPPOSED = 3  # views that must agree for each that sees through a point
_MOST_PIXELS = 60_000  # pixels of the reduced picture: 320x180 for Full HD
_DEPTHS = (64, 320)  # least and most; between them as many as the third nearest view has pixels to tell them by


def multi_view_stereo(
    cameras: Sequence[Camera],
    pictures: Sequence[npt.NDArray[np.uint8]],  # [H, W, 3] each
    wanted: Sequence[npt.NDArray[np.bool_]],  # [H, W] each: the pixels that need points
    ranges: Sequence[tuple[float, float]],  # nearest and farthest depth of each camera
    *,
    continued: bool = True,
    known: GivenDepth = no_depth,
) -> SweptPoints:
    """Return the points of surfaces that the wanted pixels show; the same bits for any number of threads.

    A third of the other views in whose pictures a point falls agree on it, and two at least, or the only other one; few
    see through it. A `known` depth needs no view to agree. Where a point falls in no other picture, the surfaces that
    were found so go on if they are `continued`. A single picture shows none.

    Raises:
        RuntimeError: no compiled kernels (`hgs_core.native.library.available`).
    """
    smaller = [_reduced(camera) for camera in cameras]
    small = [reduced_picture(picture, camera) for picture, camera in zip(pictures, smaller, strict=True)]
    left_out = [reduced_mask(~mask, camera) for mask, camera in zip(wanted, smaller, strict=True)]
    grey = [np.ascontiguousarray(picture.mean(axis=2, dtype=np.float32) / np.float32(255)) for picture in small]
    neighbours = nearest_cameras(cameras, _NEIGHBOUR_VIEWS)

    given = [known(view, size) for view, size in enumerate(smaller)]

    def sweep(view: int) -> DepthMap:
        near, far = ranges[view]
        count = _depth_count(smaller[view], [cameras[other] for other in neighbours[view]], near, far)
        inverse = np.linspace(1 / near, 1 / far, count)
        sources = [(smaller[other], grey[other]) for other in neighbours[view]]
        places, _ = plane_sweep(smaller[view], grey[view], sources, 1 / inverse)
        depths = 1 / (1 / near + places.astype(np.float64) * (1 / far - 1 / near) / (count - 1))
        return with_known(DepthMap(1, np.where(left_out[view], 0.0, depths)), given[view], left_out[view])

    def complete(found: DepthMap, mask: npt.NDArray[np.bool_], known: npt.NDArray[np.bool_]) -> DepthMap:
        inverse = completed(1 / np.where(known, found.depths, 1.0), known)
        return DepthMap(1, np.where(mask | (inverse <= 0), 0.0, 1 / np.where(inverse > 0, inverse, 1.0)))

    with core_pool() as pool:
        maps = list(pool.map(sweep, range(len(cameras))))
        surfaces = _masks(maps, _are_surfaces(_points(smaller, small, maps), maps, given))
        maps = list(pool.map(complete, maps, left_out, surfaces))
    points = _points(smaller, small, maps)
    alone = (points.facing == 0) & continued
    return points.take(_are_surfaces(points, maps, given) | alone)


def _depth_count(camera: Camera, others: Sequence[Camera], near: float, far: float) -> int:
    """Return how many depths to try: a step moves a point by a pixel in the least of the views that count."""
    apart = [float(np.linalg.norm(other.position - camera.position)) for other in others]
    pixels = camera.fx * sorted(apart)[min(2, len(apart) - 1)] * (1 / near - 1 / far) if apart else 0.0
    return int(np.clip(np.ceil(pixels), *_DEPTHS))


def _points(
    cameras: Sequence[Camera], pictures: Sequence[npt.NDArray[np.uint8]], maps: Sequence[DepthMap]
) -> SweptPoints:
    return points_of_maps(cameras, pictures, maps, agreement=_AGREEMENT, beyond=_BEYOND)


def _are_surfaces(
    points: SweptPoints, maps: Sequence[DepthMap], given: Sequence[npt.NDArray[np.float32] | None]
) -> npt.NDArray[np.bool_]:
    """Return which points of the maps count: those that views agree on, and given ones that few see through."""
    return np.asarray(_is_surface(points) | (_are_known(maps, given) & _few_see_through(points)))


def _is_surface(points: SweptPoints) -> npt.NDArray[np.bool_]:
    least = np.clip(np.ceil(points.facing * _AGREEING_SHARE), np.minimum(_AGREEING_VIEWS, points.facing), None)
    return np.asarray((points.facing > 0) & (points.agreeing >= least) & _few_see_through(points))


def _few_see_through(points: SweptPoints) -> npt.NDArray[np.bool_]:
    return np.asarray(points.opposed * _AGREEING_FOR_ONE_OPPOSED <= points.agreeing)


def _are_known(maps: Sequence[DepthMap], given: Sequence[npt.NDArray[np.float32] | None]) -> npt.NDArray[np.bool_]:
    """Return which points [P] of the maps, one after the other, have a given depth."""
    parts = [np.zeros(0, bool)]
    for found, depths in zip(maps, given, strict=True):
        mask = found.depths > 0
        parts.append(np.zeros(int(mask.sum()), bool) if depths is None else depths[mask] > 0)
    return np.concatenate(parts)


def _masks(maps: Sequence[DepthMap], chosen: npt.NDArray[np.bool_]) -> list[npt.NDArray[np.bool_]]:
    """Return the chosen pixels [h, w] of each map; those of all maps, one after the other, are [P]."""
    masks, first = [], 0
    for found in maps:
        mask = found.depths > 0
        count = int(mask.sum())
        mask[mask] = chosen[first : first + count]
        masks.append(mask)
        first += count
    return masks


def _reduced(camera: Camera) -> Camera:
    """Return the camera at the size that is swept."""
    return camera.scaled(min(1.0, math.sqrt(_MOST_PIXELS / (camera.width * camera.height))))
