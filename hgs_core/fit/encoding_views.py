"""The views for an encoding: the cameras named by its manifest, and the pictures that measure its loss."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from hgs_core.base.arrays import Floats
from hgs_core.capture.capture import Capture
from hgs_core.codec.format.start_views import StartViews
from hgs_core.fit.find_start_views import find_start_views
from hgs_core.fit.orbit_cameras import orbit_cameras
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["EncodeViews", "views_around"]

IMPORTED_FRAME_RATE = 30.0  # frames per second of a moving scene without a capture


@dataclass(frozen=True)
class EncodeViews:
    """Cameras, clock and pictures."""

    title: str
    cameras: tuple[Camera, ...]  # cameras of the manifest; viewers start at the first
    trained: Mapping[int, Camera]  # index -> camera for measurements; never a held-out one
    times: NDArray[np.float64]  # [F] seconds
    truth: Callable[[int, int], Tensor] | None  # the picture [3, H, W] of a camera and a frame, if there are any
    capture: Capture | None = None  # capture for fine-tuning
    moving: Callable[[int, int], Tensor] | None = None  # the mask [H, W] bool of a trained camera and a frame, if known
    closer: tuple[Camera, ...] = ()  # made-up ones that the manifest does not name, beyond `cameras` in `trained`
    groups: tuple[tuple[int, ...], ...] = ()  # groups of `trained` with different views; none: a single group
    photographed: bool = False  # `trained` took pictures: they tell from where the scene may be looked at
    first: int = 0  # first frame of a part of the capture
    up: tuple[float, float, float] | None = None  # unit vector, where somebody chose it; None: what the cameras tell

    @property
    def rig(self) -> list[Camera]:
        """The cameras of the pictures that made the scene; none if there are no pictures."""
        return list(self.trained.values()) if self.photographed else []

    def start_views(self, scene: HybridScene[Floats]) -> StartViews | None:
        """Return the first views of a scene; None for cameras without pictures, and where nothing moves."""
        return find_start_views(scene, self.rig) if self.photographed else None

    def first_camera(self, starts: StartViews | None) -> Camera:
        """Return the camera of the start on a wide screen."""
        return next((c for c in self.cameras if starts is not None and c.name == starts.wide.camera), self.cameras[0])

    def moment(self, camera: int, frame: int) -> float:
        """Return the second that a camera's picture of a frame shows."""
        return float(self.times[frame]) if self.capture is None else self.capture.moment(camera, self.first + frame)

    def of_frames(self, first: int, count: int) -> EncodeViews:
        """Return the views of `count` frames from `first` on, alone."""

        def later(picture: Callable[[int, int], Tensor] | None) -> Callable[[int, int], Tensor] | None:
            return None if picture is None else lambda camera, frame: picture(camera, first + frame)

        return dataclasses.replace(
            self,
            times=self.times[first : first + count],
            truth=later(self.truth),
            moving=later(self.moving),
            first=self.first + first,
        )

    @property
    def every_camera(self) -> tuple[Camera, ...]:
        """The cameras for which splats are sized."""
        return (*self.cameras, *self.closer)

    @property
    def any_background(self) -> bool:
        """Whether losses must not show on any background: no picture has one."""
        return self.truth is None


def views_around(scene: HybridScene[Floats], title: str) -> EncodeViews:
    """Return made-up views of a scene without cameras (`orbit_cameras.py`)."""
    found = orbit_cameras(scene)
    frames = max(1, round((scene.end - scene.start) * IMPORTED_FRAME_RATE))
    times = scene.start + np.arange(frames) / IMPORTED_FRAME_RATE
    seen = dict(enumerate((*found.whole, *found.closer, *found.detail)))
    edges = 0, len(found.whole), len(found.whole) + len(found.closer), len(seen)
    groups = tuple(tuple(range(*between)) for between in itertools.pairwise(edges))
    return EncodeViews(title, found.whole, seen, times, None, closer=(*found.closer, *found.detail), groups=groups)
