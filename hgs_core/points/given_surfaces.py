"""Surfaces that people know: the depth maps and the mesh of a capture, as depths of its pictures."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt

from hgs_core.base.arrays import Doubles
from hgs_core.capture.cameras.rigid_poses import MIRROR
from hgs_core.capture.capture import Capture
from hgs_core.capture.pictures.picture import reduced_mask
from hgs_core.decompose.background import sample_frames
from hgs_core.decompose.masks import MotionMasks
from hgs_core.interchange.mesh.mesh_file import read_mesh
from hgs_core.points.mesh_depth import mesh_depth
from hgs_core.scene.camera import Camera

__all__ = ["GivenSurfaces", "mesh_corners"]

_MOST_FRAMES = 11  # maps of a camera in the median over time

Depths = npt.NDArray[np.float32]


class GivenSurfaces:
    """The given surfaces of a capture; depths are 0 where none is known, and None where a camera has none."""

    def __init__(self, capture: Capture, masks: MotionMasks) -> None:
        self._capture, self._masks = capture, masks

    def still(self, camera: int, size: Camera, nearest: float = 0.0) -> Depths | None:
        """Return the depths [H, W] of the still scene, in a camera's picture at a size.

        They are the camera's own map, else the median of its maps over time without movers. The mesh fills them up
        where it is not nearer than `nearest`.

        Raises:
            InputError: a map or the mesh is unreadable.
        """
        given = self._capture.depth
        found = None if given is None else given.still_depth(camera, size)
        if found is None:
            found = self._median(camera, size)
        if self._corners is None:
            return found
        behind = mesh_depth(self._corners, size, nearest)
        return behind if found is None else np.where(found > 0, found, behind)

    def at(self, camera: int, frame: int) -> Depths | None:
        """Return the depths [H, W] of a frame at the size of the camera's picture.

        Raises:
            InputError: the map is unreadable.
        """
        given = self._capture.depth
        return None if given is None else given.depth(camera, frame, self._capture.cameras[camera])

    def _median(self, camera: int, size: Camera) -> Depths | None:
        given = self._capture.depth
        frames = [] if given is None else given.frames(camera)
        maps = []
        for place in sample_frames(len(frames), _MOST_FRAMES) if frames else []:
            depths = None if given is None else given.depth(camera, frames[place], size)
            if depths is not None:
                moving = reduced_mask(self._masks.mask(camera, frames[place]), size)
                maps.append(np.where(moving | (depths == 0), np.float32(np.inf), depths))
        if not maps:
            return None
        ordered = np.sort(np.stack(maps), axis=0)  # unknown depths come last
        known = np.isfinite(ordered).sum(0)
        middle = np.take_along_axis(ordered, np.maximum(known - 1, 0)[None] // 2, 0)[0]
        return np.where(known > 0, middle, np.float32(0))

    @cached_property
    def _corners(self) -> Doubles | None:
        return mesh_corners(self._capture)


def mesh_corners(capture: Capture) -> Doubles | None:
    """Return the corners [T, 3, 3] of the given mesh's triangles, in the world of the cameras; None without a mesh.

    Raises:
        InputError: the mesh is unreadable.
    """
    if capture.mesh is None:
        return None
    corners = read_mesh(capture.mesh).corners
    return corners @ MIRROR[:3, :3] if capture.mirrored else corners
