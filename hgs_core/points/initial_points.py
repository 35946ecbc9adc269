"""The first points of a scene: interleaved-frame structure from motion, filled up by plane sweeps.

Static points come from the first moment and from the still background, dynamic points from moments in between, as the
interleaved-frame initialisation of HGS has it. Features give exact points where there is texture; the sweeps give the
rest of the pictures theirs, so that the targets are met wherever the pictures allow.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.base.wording import counted
from hgs_core.capture.capture import Capture
from hgs_core.decompose.background import median_picture, sample_frames
from hgs_core.decompose.masks import MotionMasks
from hgs_core.native import library
from hgs_core.points.depth_map import SweptPoints
from hgs_core.points.multi_view_stereo import multi_view_stereo
from hgs_core.points.neighbours import mean_neighbour_distance, thin
from hgs_core.points.point_cloud import PointCloud
from hgs_core.points.point_labels import label_points
from hgs_core.points.same_moment import SameMoment, same_moments
from hgs_core.points.scene_flow import point_velocities
from hgs_core.points.sfm import triangulate
from hgs_core.points.surface_normals import surface_normals
from hgs_core.points.sweep import depth_ranges, sweep
from hgs_core.scene.camera import Camera

__all__ = ["initial_points"]

_STAGE = "points"
_MOST_COARSE_POINTS = 6_000  # points of a coarse sweep; more of them have wrong depths
_RAYS_PER_POINT = 4  # swept pixels for each point wanted: the better ones are taken
_MOVING_SHARE = 0.5  # share of the views from which on a point is dynamic
_MOST_AGREEING_VIEWS = 3  # views that agree on a depth, beyond which more of them mean no more
_MIN_VIEWS = 2
_STILL_FRAMES = 11  # frames in the median that is a camera's still picture
# Share of the sampled frames in which a pixel moves, from which on its background means nothing.
_UNKNOWN_BACKGROUND_SHARE = 0.5
_MAX_SPACING = 3.0  # times the median: a lone point must not start as a giant


def initial_points(
    capture: Capture,
    cameras: Sequence[int],  # the training cameras; no other is read
    masks: MotionMasks,
    *,
    moments: Sequence[int],  # frames, ascending, that dynamic points are taken from
    static_target: int,
    dynamic_target: int,  # points of all moments
    stereo: bool = True,
    continued: bool = True,
    normals: bool = False,
    seed: int,
    progress: ProgressCallback,
) -> PointCloud:
    """Return labelled points of the scene; about the targets' numbers wherever the pictures allow.

    The result is the same for the same arguments, whatever the number of threads.

    Raises:
        InputError: fewer than two cameras, or a picture is missing or unreadable.
        StageStopped: the callback wishes so.
    """
    if len(cameras) < _MIN_VIEWS:
        raise InputError(
            capture.path, f"{counted(len(cameras), 'camera')} to start from", "points need at least two views"
        )
    generator = np.random.default_rng(seed)
    views = [capture.cameras[index] for index in cameras]
    steps = len(moments) + 2
    progress(Progress(_STAGE, 0, steps))

    whole = SameMoment(float(capture.times[moments[0]]), tuple(cameras), (moments[0],) * len(cameras))
    first = _sparse(capture, whole, masks, whole=True)
    still = first.take(first.dynamic < _MOVING_SHARE)
    ranges = depth_ranges(views, first.xyz)
    progress(Progress(_STAGE, 1, steps))

    missing = max(0, static_target - len(still))
    seeds = _static_seeds(capture, cameras, masks, ranges, missing, stereo, continued, generator)
    still = PointCloud.concatenate([still, seeds])
    still = _spaced(_reduced(still, static_target, generator))
    parts = [dataclasses.replace(still, normal=surface_normals(still.xyz)) if normals else still]
    progress(Progress(_STAGE, 2, steps))

    for number, frame in enumerate(moments):
        quota = dynamic_target * (number + 1) // len(moments) - dynamic_target * number // len(moments)
        groups = same_moments(capture, cameras, frame)
        grouped = sum(len(group.cameras) for group in groups)
        shares = [quota * len(group.cameras) // grouped for group in groups]
        shares[0] += quota - sum(shares)
        for group, share in zip(groups, shares, strict=True):
            known = first if number == 0 and group == whole else _sparse(capture, group, masks, whole=False)
            moving = known.take(known.dynamic >= _MOVING_SHARE)
            near = [ranges[cameras.index(index)] for index in group.cameras]
            seeds = _dynamic_seeds(capture, group, masks, near, max(0, share - len(moving)), generator)
            moving = _spaced(_reduced(PointCloud.concatenate([moving, seeds]), share, generator))
            velocity = point_velocities(capture, group, masks, moving.xyz)
            parts.append(dataclasses.replace(moving, velocity=velocity))
        progress(Progress(_STAGE, number + 3, steps, {"points": float(sum(len(part) for part in parts))}))
    return PointCloud.concatenate(parts)


def _sparse(capture: Capture, moment: SameMoment, masks: MotionMasks, *, whole: bool) -> PointCloud:
    """Triangulate the features of one moment: those of whole pictures, or only those that move."""
    views, pictures, moving = _seen_at(capture, moment, masks)
    found = triangulate(views, pictures, None if whole else moving)
    dynamic = label_points(views, moving, found.xyz, found.seen)
    return _cloud(found.xyz, found.rgb, moment.seconds, dynamic)


def _seen_at(
    capture: Capture, moment: SameMoment, masks: MotionMasks
) -> tuple[list[Camera], list[npt.NDArray[np.uint8]], list[npt.NDArray[np.bool_]]]:
    """Return the cameras, their pictures [H, W, 3] and motion masks [H, W]."""
    views = [capture.cameras[index] for index in moment.cameras]
    own = list(zip(moment.cameras, moment.frames, strict=True))
    return views, [capture.frame(*one) for one in own], [masks.mask(*one) for one in own]


def _static_seeds(
    capture: Capture,
    cameras: Sequence[int],
    masks: MotionMasks,
    ranges: Sequence[tuple[float, float]],
    count: int,
    stereo: bool,
    continued: bool,
    generator: np.random.Generator,
) -> PointCloud:
    """Find the surfaces of the pictures' median over time, which nothing that moves disturbs.

    Without the compiled kernels, or without stereo, a coarse sweep has to do, of which no more points are worth having
    than a few thousand.
    """
    views = [capture.cameras[index] for index in cameras]
    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        backgrounds = list(pool.map(lambda index: _still_picture(capture, masks, index), cameras))
    pictures = [picture for picture, _ in backgrounds]
    trusted = [mask for _, mask in backgrounds]
    if stereo and library.available():
        swept = multi_view_stereo(views, pictures, trusted, ranges, continued=continued)
        chosen = np.sort(generator.permutation(len(swept.xyz))[:count])
    else:
        count = min(count, _MOST_COARSE_POINTS)
        swept = sweep(views, pictures, trusted, ranges, count * _RAYS_PER_POINT)
        chosen = _choose(swept, count, generator)
    return _cloud(swept.xyz[chosen], swept.rgb[chosen], float(capture.times[0]), np.zeros(len(chosen), np.float32))


def _still_picture(
    capture: Capture, masks: MotionMasks, camera: int
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.bool_]]:
    """Return the median picture [H, W, 3] of a camera over time and the pixels [H, W] where it is the background."""
    sampled = sample_frames(len(capture.times), _STILL_FRAMES)
    picture = median_picture(np.stack([capture.frame(camera, frame) for frame in sampled]))
    moving = np.mean([masks.mask(camera, frame) for frame in sampled], axis=0)
    return picture, np.asarray(moving < _UNKNOWN_BACKGROUND_SHARE)


def _dynamic_seeds(
    capture: Capture,
    moment: SameMoment,
    masks: MotionMasks,
    ranges: Sequence[tuple[float, float]],
    count: int,
    generator: np.random.Generator,
) -> PointCloud:
    """Sweep the moving pixels of one moment inside the visual hull of the masks."""
    views, pictures, moving = _seen_at(capture, moment, masks)
    if count == 0 or not any(mask.any() for mask in moving):
        return PointCloud.concatenate([])

    swept = sweep(views, pictures, moving, ranges, count * _RAYS_PER_POINT, moving)
    chosen = _choose(swept, count, generator)
    chosen = chosen[swept.agreeing[chosen] > 0]  # rather too few: a wrong moving point is in the way of the view
    share = label_points(views, moving, swept.xyz[chosen])
    return _cloud(swept.xyz[chosen], swept.rgb[chosen], moment.seconds, share)


def _choose(swept: SweptPoints, count: int, generator: np.random.Generator) -> npt.NDArray[np.int64]:
    """Return the rows of at most `count` points: at random among the best confirmed, then among the next best.

    A point that more views see through than confirm hangs in empty space and is left out.
    """
    confirmed = np.minimum(swept.agreeing, _MOST_AGREEING_VIEWS)
    order = np.lexsort((generator.random(len(swept.xyz)), -confirmed))
    return np.sort(order[swept.opposed[order] <= swept.agreeing[order]][:count])


def _cloud(
    xyz: npt.NDArray[np.float32], rgb: npt.NDArray[np.float32], time: float, dynamic: npt.NDArray[np.float32]
) -> PointCloud:
    times, none = np.full(len(xyz), time, np.float32), np.zeros(len(xyz), np.float32)
    return PointCloud.at_rest(xyz, rgb, times, dynamic, none)


def _reduced(cloud: PointCloud, count: int, generator: np.random.Generator) -> PointCloud:
    """Drop duplicates, and points at random beyond `count`."""
    typical = float(np.median(mean_neighbour_distance(cloud.xyz))) if len(cloud) else 0.0
    cloud = cloud.take(thin(cloud.xyz, 0.1 * typical))
    if len(cloud) <= count:
        return cloud
    return cloud.take(np.sort(generator.permutation(len(cloud))[:count]))


def _spaced(cloud: PointCloud) -> PointCloud:
    """Fill in the mean distance to the three nearest neighbours, at most three times the median."""
    spacing = mean_neighbour_distance(cloud.xyz)
    positive = spacing[spacing > 0]
    typical = np.median(positive) if len(positive) else np.float32(1e-2)
    spacing = np.where(spacing > 0, np.minimum(spacing, _MAX_SPACING * typical), typical)
    return dataclasses.replace(cloud, spacing=spacing.astype(np.float32))
