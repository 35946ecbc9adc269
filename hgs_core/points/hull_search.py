"""First points of cameras that stand far apart: movers on their visual hull, and the still room on its backdrop.

Given depths come before both.
"""

from __future__ import annotations

import dataclasses
from functools import cached_property

import numpy as np
import numpy.typing as npt

from hgs_core.decompose.background import sample_frames
from hgs_core.points.backdrop import Backdrop, find_backdrop
from hgs_core.points.hull_surface import HullSurface, grid_rays, grid_step, hull_surface
from hgs_core.points.initial_points import PointSearch, Ranges
from hgs_core.points.pictures_of_moments import seen_at, still_pictures
from hgs_core.points.point_cloud import PointCloud
from hgs_core.points.same_moment import SameMoment, same_moments
from hgs_core.points.scene_flow import point_velocities
from hgs_core.points.still_depths import StillDepths
from hgs_core.scene.camera import Camera

__all__ = ["HullSearch"]

_FLOOR_FRAMES = 12  # frames whose movers show where the floor is
_FLOOR_RAYS = 2_000  # rays of each
_NEARER = 0.25  # share of the movers' median depth; a given mesh there hides what the camera films


class HullSearch(PointSearch):
    """A search that asks no two pictures of movers to look alike."""

    @cached_property
    def backdrop(self) -> Backdrop:
        """The surface on which all that stands still is placed.

        Raises:
            InputError: a picture is missing or unreadable; so do the other methods.
        """
        parts = []
        for frame in sample_frames(len(self.capture.times), _FLOOR_FRAMES):
            for group in same_moments(self.capture, self.cameras, frame):
                parts.append(self._surface(group, _FLOOR_RAYS).xyz)
        views = [self.capture.cameras[index] for index in self.cameras]
        movers = np.concatenate(parts)
        found = find_backdrop(views, self._still, movers)
        given = {}
        for index, view in zip(self.cameras, views, strict=True):
            _, depths = view.project(movers)
            nearest = _NEARER * float(np.median(depths[depths > 0])) if (depths > 0).any() else 0.0
            known = self._surfaces.still(index, view, nearest)
            if known is not None:
                given[view.name] = known
        return dataclasses.replace(found, given=StillDepths(given)) if given else found

    @cached_property
    def _still(self) -> list[tuple[npt.NDArray[np.uint8], npt.NDArray[np.bool_]]]:
        return still_pictures(self.capture, self.masks, self.cameras)

    def features(self, frame: int) -> PointCloud:
        """Return no points: features have no partners."""
        return PointCloud.concatenate([])

    def still(self, features: PointCloud, ranges: Ranges, generator: np.random.Generator) -> PointCloud:
        """Return static points: those of the still pictures at their given depths, else on the backdrop."""
        views = [self.capture.cameras[index] for index in self.cameras]
        pictures = self._still
        step = grid_step([trusted for _, trusted in pictures], self.static_target)
        parts = []
        for camera, (picture, trusted) in zip(views, pictures, strict=True):
            rows, columns, rays = grid_rays(camera, trusted, step)
            depths = self.backdrop.depths(camera.position, rays)
            normals = self.backdrop.nearest(camera.position + rays * depths[:, None])[1]
            if self.backdrop.given is not None:
                given, facing = self.backdrop.given.at(camera, rows, columns)
                depths, normals = np.where(given > 0, given, depths), np.where(given[:, None] > 0, facing, normals)
            xyz = camera.position + rays * depths[:, None]
            parts.append(
                PointCloud(
                    xyz.astype(np.float32),
                    (picture[rows, columns] / 255.0).astype(np.float32),
                    np.full(len(xyz), self.capture.times[0], np.float32),
                    np.zeros(len(xyz), np.float32),
                    (step * depths / camera.fx).astype(np.float32),
                    np.zeros((len(xyz), 3), np.float32),
                    normals.astype(np.float32),
                )
            )
        return PointCloud.concatenate(parts)

    def moving(
        self,
        frame: int,
        count: int,
        ranges: Ranges,
        generator: np.random.Generator,
        features: PointCloud | None = None,
    ) -> PointCloud:
        """Return at most `count` points at a frame, at given depths in the hull, else on its surface."""
        groups = same_moments(self.capture, self.cameras, frame)
        parts = []
        for group in groups:
            found = self._surface(group, count // len(groups))
            chosen = np.sort(generator.permutation(len(found.xyz))[: count // len(groups)])
            xyz = found.xyz[chosen]
            parts.append(
                PointCloud(
                    xyz,
                    found.rgb[chosen],
                    np.full(len(xyz), group.seconds, np.float32),
                    np.ones(len(xyz), np.float32),
                    found.spacing[chosen] * np.float32(np.sqrt(len(found.xyz) / max(1, len(xyz)))),
                    point_velocities(self.capture, group, self.masks, xyz),
                    found.towards[chosen],
                )
            )
        return PointCloud.concatenate(parts)

    def _surface(self, group: SameMoment, rays: int) -> HullSurface:
        def known(view: int, size: Camera) -> npt.NDArray[np.float32] | None:
            return self._surfaces.at(group.cameras[view], group.frames[view])

        return hull_surface(*seen_at(self.capture, group, self.masks), rays, known)
