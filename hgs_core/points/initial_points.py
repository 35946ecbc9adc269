"""The first points of a scene: interleaved-frame structure from motion, filled up by plane sweeps.

Static points come from the first moment and from the still background, dynamic points from moments in between, as the
interleaved-frame initialisation of HGS has it. Features give exact points where there is texture; the sweeps give the
rest of the pictures theirs, so that the targets are met wherever the pictures allow.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted
from hgs_core.capture.capture import Capture
from hgs_core.decompose.masks import MotionMasks
from hgs_core.native import library
from hgs_core.points.backdrop import Backdrop
from hgs_core.points.depth_map import SweptPoints
from hgs_core.points.given_surfaces import GivenSurfaces
from hgs_core.points.multi_view_stereo import multi_view_stereo
from hgs_core.points.neighbours import mean_neighbour_distance, thin
from hgs_core.points.pictures_of_moments import seen_at, still_pictures
from hgs_core.points.point_cloud import PointCloud
from hgs_core.points.point_labels import label_points
from hgs_core.points.same_moment import SameMoment, same_moments
from hgs_core.points.scene_flow import point_velocities
from hgs_core.points.sfm import triangulate
from hgs_core.points.surface_normals import surface_normals
from hgs_core.points.sweep import depth_ranges, sweep
from hgs_core.scene.camera import Camera

__all__ = ["PointSearch", "Ranges"]

Ranges = Sequence[tuple[float, float]]
"""Nearest and farthest depth of each training camera, world units."""

_MOST_COARSE_POINTS = 6_000  # points of a coarse sweep; more of them have wrong depths
_RAYS_PER_POINT = 4  # swept pixels for each point wanted: the better ones are taken
_MOVING_SHARE = 0.5  # share of the views from which on a point is dynamic
_MOST_AGREEING_VIEWS = 3  # views that agree on a depth, beyond which more of them mean no more
_MIN_VIEWS = 2
_NEARER = 0.5  # share of a camera's nearest depth of interest; a given mesh there hides what it films
_MAX_SPACING = 3.0  # times the median: a lone point must not start as a giant


@dataclass(frozen=True)
class PointSearch:
    """A search for the labelled first points of a scene; about the targets' numbers wherever the pictures allow.

    What it finds is the same for the same arguments, whatever the number of threads.
    """

    capture: Capture
    cameras: Sequence[int]  # the training cameras; no other is read
    masks: MotionMasks
    static_target: int
    dynamic_target: int  # points of all moments
    stereo: bool = True
    continued: bool = True
    normals: bool = False

    @cached_property
    def _surfaces(self) -> GivenSurfaces:
        return GivenSurfaces(self.capture, self.masks)

    def __post_init__(self) -> None:
        """Check the number of cameras.

        Raises:
            InputError: there are fewer than two.
        """
        if len(self.cameras) < _MIN_VIEWS:
            problem = f"{counted(len(self.cameras), 'camera')} to start from"
            raise InputError(self.capture.path, problem, "points need at least two views")

    @property
    def backdrop(self) -> Backdrop | None:
        """The surface on which all that stands still is placed; None where pictures agree on its places."""
        return None

    def features(self, frame: int) -> PointCloud:
        """Return the points of the features of whole pictures at a frame, moving ones included.

        Raises:
            InputError: a picture is missing or unreadable; so do the other methods.
        """
        return _sparse(self.capture, self._together(frame), self.masks, whole=True)

    def ranges(self, features: PointCloud) -> Ranges:
        """Return the depths between which the sweeps look."""
        return depth_ranges([self.capture.cameras[index] for index in self.cameras], features.xyz)

    def still(self, features: PointCloud, ranges: Ranges, generator: np.random.Generator) -> PointCloud:
        """Return static points: those of the features of the first moment, and of the background."""
        still = features.take(features.dynamic < _MOVING_SHARE)
        missing = max(0, self.static_target - len(still))
        seeds = _static_seeds(
            self.capture,
            self.cameras,
            self.masks,
            ranges,
            missing,
            self.stereo,
            self.continued,
            generator,
            self._surfaces,
        )
        still = PointCloud.concatenate([still, seeds])
        still = _spaced(_reduced(still, self.static_target, generator))
        return dataclasses.replace(still, normal=surface_normals(still.xyz)) if self.normals else still

    def moving(
        self,
        frame: int,
        count: int,
        ranges: Ranges,
        generator: np.random.Generator,
        features: PointCloud | None = None,
    ) -> PointCloud:
        """Return about `count` moving points at a frame; `features` are those of this frame, where known."""
        groups = same_moments(self.capture, self.cameras, frame)
        grouped = sum(len(group.cameras) for group in groups)
        shares = [count * len(group.cameras) // grouped for group in groups]
        shares[0] += count - sum(shares)
        parts = []
        for group, share in zip(groups, shares, strict=True):
            known = features if group == self._together(frame) else None
            if known is None:
                known = _sparse(self.capture, group, self.masks, whole=False)
            moving = known.take(known.dynamic >= _MOVING_SHARE)
            near = [ranges[self.cameras.index(index)] for index in group.cameras]
            seeds = _dynamic_seeds(
                self.capture, group, self.masks, near, max(0, share - len(moving)), generator, self._surfaces
            )
            moving = _spaced(_reduced(PointCloud.concatenate([moving, seeds]), share, generator))
            velocity = point_velocities(self.capture, group, self.masks, moving.xyz)
            parts.append(dataclasses.replace(moving, velocity=velocity))
        return PointCloud.concatenate(parts)

    def _together(self, frame: int) -> SameMoment:
        """Return a frame of all cameras, as if they were in step."""
        return SameMoment(float(self.capture.times[frame]), tuple(self.cameras), (frame,) * len(self.cameras))


def _sparse(capture: Capture, moment: SameMoment, masks: MotionMasks, *, whole: bool) -> PointCloud:
    """Triangulate the features of one moment: those of whole pictures, or only those that move."""
    views, pictures, moving = seen_at(capture, moment, masks)
    found = triangulate(views, pictures, None if whole else moving)
    dynamic = label_points(views, moving, found.xyz, found.seen)
    return _cloud(found.xyz, found.rgb, moment.seconds, dynamic)


def _static_seeds(
    capture: Capture,
    cameras: Sequence[int],
    masks: MotionMasks,
    ranges: Ranges,
    count: int,
    stereo: bool,
    continued: bool,
    generator: np.random.Generator,
    surfaces: GivenSurfaces,
) -> PointCloud:
    """Find the surfaces of the pictures' median over time, which nothing that moves disturbs.

    Without the compiled kernels, or without stereo, a coarse sweep has to do, of which no more points are worth having
    than a few thousand.
    """
    views = [capture.cameras[index] for index in cameras]
    backgrounds = still_pictures(capture, masks, cameras)
    pictures = [picture for picture, _ in backgrounds]
    trusted = [mask for _, mask in backgrounds]

    def known(view: int, size: Camera) -> npt.NDArray[np.float32] | None:
        return surfaces.still(cameras[view], size, _NEARER * ranges[view][0])

    if stereo and library.available():
        swept = multi_view_stereo(views, pictures, trusted, ranges, continued=continued, known=known)
        chosen = np.sort(generator.permutation(len(swept.xyz))[:count])
    else:
        count = min(count, _MOST_COARSE_POINTS)
        swept = sweep(views, pictures, trusted, ranges, count * _RAYS_PER_POINT, known=known)
        chosen = _choose(swept, count, generator)
    return _cloud(swept.xyz[chosen], swept.rgb[chosen], float(capture.times[0]), np.zeros(len(chosen), np.float32))


def _dynamic_seeds(
    capture: Capture,
    moment: SameMoment,
    masks: MotionMasks,
    ranges: Ranges,
    count: int,
    generator: np.random.Generator,
    surfaces: GivenSurfaces,
) -> PointCloud:
    """Sweep the moving pixels of one moment inside the visual hull of the masks."""
    views, pictures, moving = seen_at(capture, moment, masks)
    if count == 0 or not any(mask.any() for mask in moving):
        return PointCloud.concatenate([])

    def known(view: int, size: Camera) -> npt.NDArray[np.float32] | None:
        return surfaces.at(moment.cameras[view], moment.frames[view])

    swept = sweep(views, pictures, moving, ranges, count * _RAYS_PER_POINT, moving, known)
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
