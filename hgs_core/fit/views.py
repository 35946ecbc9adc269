"""What a scene is encoded for: the cameras that its manifest names, and the pictures that tell what is lost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from hgs_core.capture.capture import Capture
from hgs_core.points.near_plane import with_near_planes
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["EncodeViews", "views_around"]

IMPORTED_FRAME_RATE = 30.0  # of a moving scene that came without a capture
RINGS = ((8, -0.35), (8, 0.0), (8, 0.35))  # cameras, and their height over the distance
DISTANCE = 2.6  # in median distances of the splats from their middle
SIZE = (640, 480)  # pixels
FOCAL = 560.0

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class EncodeViews:
    """Cameras, clock and pictures."""

    title: str
    cameras: tuple[Camera, ...]
    trained: Mapping[int, Camera]  # by index: those that may be looked at; never those held out
    times: NDArray[np.float64]  # [F] seconds
    truth: Callable[[int, int], Tensor] | None  # the picture [3, H, W] of a camera and a frame, if there are any
    capture: Capture | None = None  # to train further with


def views_around(scene: HybridScene[Floats], title: str) -> EncodeViews:
    """Return views for a scene without cameras: three rings of eight around the middle of its splats, looking at it."""
    places = [scene.static.means, *(segment.dynamic.motion[:, 0] for segment in scene.segments)]
    points = np.concatenate(places).astype(np.float64)
    middle = np.median(points, axis=0)
    radius = float(np.median(np.linalg.norm(points - middle, axis=1))) or 1.0
    cameras: list[Camera] = []
    for count, height in RINGS:
        for i in range(count):
            angle = 2 * np.pi * (i + height) / count
            aside = np.array([np.cos(angle), -height, np.sin(angle)])
            cameras.append(_looking(f"view{len(cameras):02}", middle + DISTANCE * radius * aside, middle))
    planes = with_near_planes(cameras, points.astype(np.float32))
    frames = max(1, round((scene.end - scene.start) * IMPORTED_FRAME_RATE))
    times = scene.start + np.arange(frames) / IMPORTED_FRAME_RATE
    return EncodeViews(title, planes, dict(enumerate(planes)), times, None)


def _looking(name: str, position: NDArray[np.float64], target: NDArray[np.float64]) -> Camera:
    """Return a camera that looks at a point, the world's y pointing down."""
    forward = (target - position) / np.linalg.norm(target - position)
    right = np.cross([0.0, 1.0, 0.0], forward)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = [right, np.cross(forward, right), forward]
    pose[:3, 3] = -pose[:3, :3] @ position
    width, height = SIZE
    return Camera(name, width, height, FOCAL, FOCAL, width / 2, height / 2, pose)
