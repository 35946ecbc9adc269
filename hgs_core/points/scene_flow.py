"""Scene flow: where the points of one moment are a frame later, by the agreement of all views.

A splat that starts at rest on something fast learns nothing from where the thing has gone: their pictures no longer
overlap. So we search around each point for the place where every view that sees it move shows the same colours a frame
later, in coarse pictures first. (Vedula et al., ICCV 1999, have it from the optical flow of the views.)
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from typing import Any

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import reduced_picture
from hgs_core.decompose.masks import MotionMasks
from hgs_core.decompose.morphology import box_sum
from hgs_core.points.colour_difference import colour_difference
from hgs_core.points.same_moment import SameMoment
from hgs_core.points.visibility import pixels_inside
from hgs_core.scene.camera import Camera

__all__ = ["point_velocities", "scene_flow"]

_PYRAMID = ((0.25, 5), (0.5, 2), (1.0, 2))  # size of the pictures, and the pixels around that are looked at
_BLOCKED_ERROR = 40.0  # levels of 255: a view that disagrees by more does not see the point, and counts no further
_EFFORT_PER_PIXEL = 0.3  # levels per pixel: of two equally good places the nearer one
_NEIGHBOURS = 8  # points that move alike
_LEADERS = 500  # points that look far around themselves, most of the work; the others begin where the nearest one ended
_FEWEST_VIEWS = 2
_SLOWEST_SPEED = 1.5  # pixels per frame: what is slower is left at rest, as displacements are found in whole pixels

Floats = npt.NDArray[np.floating[Any]]


def point_velocities(
    capture: Capture,
    moment: SameMoment,
    masks: MotionMasks,
    xyz: Floats,  # [P, 3] where the points are at that moment
) -> npt.NDArray[np.float32]:
    """Return [P, 3] the velocities of points, world units per second: the mean of those to the frames on both sides."""
    views = [capture.cameras[index] for index in moment.cameras]
    own = list(zip(moment.cameras, moment.frames, strict=True))
    now = [capture.frame(index, frame) for index, frame in own]
    moving = [masks.mask(index, frame) for index, frame in own]
    total, sides = np.zeros((len(xyz), 3)), 0
    for step in (-1, 1):
        if all(0 <= frame + step < len(capture.times) for frame in moment.frames):
            then = [capture.frame(index, frame + step) for index, frame in own]
            apart = [capture.moment(index, frame + step) - capture.moment(index, frame) for index, frame in own]
            total += scene_flow(views, now, then, moving, xyz) / float(np.median(apart))
            sides += 1
    return (total / max(sides, 1)).astype(np.float32)


def scene_flow(
    cameras: Sequence[Camera],
    now: Sequence[npt.NDArray[np.uint8]],  # [H, W, 3] of each camera, when the points are where they are
    later: Sequence[npt.NDArray[np.uint8]],  # [H, W, 3] a frame later (or earlier)
    moving: Sequence[npt.NDArray[np.bool_]],  # [H, W] what moves now
    xyz: Floats,  # [P, 3]
) -> npt.NDArray[np.float32]:
    """Return [P, 3] by how much each point moves until then, world units; zero where fewer than two views see it move.

    Displacements from 1.5 to 20 pixels are found; smaller ones count as zero.
    """
    flow = np.zeros((len(xyz), 3))
    if len(xyz) == 0:
        return flow.astype(np.float32)
    seen = np.zeros((len(cameras), len(xyz)), np.bool_)
    pixel = np.full((len(cameras), len(xyz)), np.nan)
    for view, (camera, mask) in enumerate(zip(cameras, moving, strict=True)):
        rows, columns = pixels_inside(camera, xyz)
        seen[view, rows] = mask[columns[:, 1], columns[:, 0]]
        pixel[view, rows] = camera.project(np.asarray(xyz)[rows])[1] / camera.fx
    known = np.flatnonzero(seen.sum(0) >= _FEWEST_VIEWS)
    if len(known) == 0:
        return flow.astype(np.float32)
    points, seen = np.asarray(xyz, np.float64)[known], seen[:, known]
    unit = np.nanmean(pixel[:, known], axis=0)  # world units per pixel
    leaders = np.unique(np.linspace(0, len(points) - 1, _LEADERS).astype(np.int64))
    follow = _squares(points, points[leaders]).argmin(1)
    alike = _nearest(points)
    found = np.zeros_like(points)
    with core_pool() as pool:
        for level, (size, radius) in enumerate(_PYRAMID):
            rows, near = (leaders, _nearest(points[leaders])) if level == 0 else (np.arange(len(points)), alike)
            steps = _ball(radius)
            trials = points[rows, None] + found[rows, None] + steps * (unit[rows] / size)[:, None, None]
            cost = _disagreement(pool, cameras, now, later, seen[:, rows], points[rows], trials, size)
            cost += _EFFORT_PER_PIXEL * np.linalg.norm(steps, axis=1).astype(np.float32) / size
            if level == 0:
                cost = cost[near].mean(1)  # all of them start from the same place
            best = (trials - points[rows, None])[np.arange(len(rows)), cost.argmin(1)]
            best = np.median(best[near], axis=1)
            found = best[follow] if level == 0 else best
    quick = np.linalg.norm(found, axis=1) >= _SLOWEST_SPEED * unit
    flow[known[quick]] = found[quick]
    return flow.astype(np.float32)


def _disagreement(
    pool: Executor,
    cameras: Sequence[Camera],
    now: Sequence[npt.NDArray[np.uint8]],
    later: Sequence[npt.NDArray[np.uint8]],
    seen: npt.NDArray[np.bool_],  # [C, P]
    points: npt.NDArray[np.float64],  # [P, 3]
    trials: npt.NDArray[np.float64],  # [P, K, 3]
    size: float,
) -> npt.NDArray[np.float32]:
    """Return [P, K] the mean over the views of by how much the colours differ, levels of 255."""

    def in_view(
        camera: Camera, first: npt.NDArray[np.uint8], second: npt.NDArray[np.uint8], rows: npt.NDArray[np.bool_]
    ) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float32]]:
        small = camera.scaled(size)
        asked = np.flatnonzero(rows)
        cost = np.full((len(asked), trials.shape[1]), _BLOCKED_ERROR, np.float32)
        if len(asked) > 0:
            before, after = (_smooth(reduced_picture(picture, small)) for picture in (first, second))
            own = np.full((len(asked), 3), -1000, np.int16)
            inside, at = pixels_inside(small, points[asked])
            own[inside] = before[at[:, 1], at[:, 0]]
            inside, at = pixels_inside(small, trials[asked].reshape(-1, 3))
            difference = colour_difference(after[at[:, 1], at[:, 0]], own[inside // trials.shape[1]])
            cost.reshape(-1)[inside] = np.minimum(difference, _BLOCKED_ERROR)
        return asked, cost

    total = np.zeros(trials.shape[:2], np.float32)
    for asked, cost in pool.map(in_view, cameras, now, later, seen):
        total[asked] += cost
    return np.asarray(total / np.maximum(seen.sum(0), 1)[:, None], np.float32)


def _smooth(picture: npt.NDArray[np.uint8]) -> npt.NDArray[np.int16]:
    return np.asarray(box_sum(picture.astype(np.int16), 1) // 9, np.int16)


def _ball(radius: int) -> npt.NDArray[np.float64]:
    """Return the whole-numbered places [K, 3] within `radius` of the origin, which comes first."""
    axis = np.arange(-radius, radius + 1)
    places = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3).astype(np.float64)
    length = np.linalg.norm(places, axis=1)
    order = np.argsort(length, kind="stable")
    return np.asarray(places[order][length[order] <= radius])


def _nearest(points: npt.NDArray[np.float64]) -> npt.NDArray[np.int64]:
    """Return [P, k] the rows of each point's nearest points, itself among them."""
    count = min(_NEIGHBOURS, len(points))
    return np.asarray(np.argpartition(_squares(points, points), count - 1, axis=1)[:, :count])


def _squares(points: npt.NDArray[np.float64], others: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the squared distances [P, Q] of points [P, 3] from others [Q, 3]."""
    return np.asarray((points**2).sum(1)[:, None] + (others**2).sum(1) - 2 * points @ others.T)
