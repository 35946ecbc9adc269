"""The choice of a scene's first views: cameras that show all movers of the first seconds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.codec.format.start_views import StartView, StartViews
from hgs_core.render.contributions import contributions
from hgs_core.render.moment import moment_of_dynamic
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["find_start_views"]

SECONDS = 2.0  # stretch from the scene's start
MOMENTS = 4  # moments looked at
SIDE = 160  # pixels; longer side of the pictures that weigh movers
WIDE, TALL = 16 / 10, 390 / 844  # width over height of a desktop's window and of a phone held upright
LEFT_OUT = 0.01  # weight of movers beyond each side of a box
MARGIN = 0.04  # room around the movers, in parts of the box


@dataclass(frozen=True)
class _Movers:
    points: Doubles  # [K, 3] world units
    weights: Doubles  # [K] visible area, world units squared; their sum is 1


def find_start_views(scene: HybridScene[NDArray[np.float32]], cameras: Sequence[Camera]) -> StartViews | None:
    """Return the views that show all movers, and show them large; None where nothing moves in the first seconds.

    A box holds all movers but those that hardly show. The views with the least around the camera's own picture win,
    then the largest movers in the middle, then cameras in the middle of the rig.
    """
    movers = _movers(scene, cameras)
    if movers is None:
        return None
    places = np.array([camera.position for camera in cameras])
    away = np.linalg.norm(places - places.mean(axis=0), axis=1)
    off_centre = away / max(away.max(), 1e-12)
    found = {camera.name: box for camera in cameras if (box := _box(camera, movers)) is not None}
    if not found:
        return None

    def best(aspect: float) -> StartView:
        costs = {
            camera.name: _cost(camera, found[camera.name], aspect) + 0.1 * off_centre[i]
            for i, camera in enumerate(cameras)
            if camera.name in found
        }
        name = min(costs, key=lambda name: costs[name])
        return StartView(name, found[name])

    return StartViews(best(WIDE), best(TALL))


def _movers(scene: HybridScene[NDArray[np.float32]], cameras: Sequence[Camera]) -> _Movers | None:
    """Return the moving splats of the first seconds, weighted by the area that the cameras see of them."""
    tensors = scene.map(torch.from_numpy)
    still = len(tensors.static)
    points, weights = [], []
    for seconds in np.linspace(scene.start, min(scene.end, scene.start + SECONDS), MOMENTS):
        segment = tensors.segment_at(float(seconds))
        if len(segment.dynamic) == 0:
            continue
        moment = segment.normalised(float(seconds))
        place = moment_of_dynamic(segment.dynamic, moment).means.numpy()
        seen = np.zeros(len(place))
        for camera in cameras:
            small = camera.within(SIDE)
            shown = contributions(tensors.static, segment.dynamic, small, moment, antialiased=scene.antialiased)
            _, depth = small.project(place)
            seen += shown.total[still:] * (np.maximum(depth, 0) / small.fx) ** 2
        points.append(place[seen > 0])
        weights.append(seen[seen > 0])
    if not points or not any(len(place) for place in points):
        return None
    joined = np.concatenate(weights)
    return _Movers(np.concatenate(points), joined / joined.sum())


def _box(camera: Camera, movers: _Movers) -> tuple[float, float, float, float] | None:
    """Return the box of the movers in the plane of a picture, pixels; None with some of them behind the camera."""
    pixels, depths = camera.project(movers.points)
    before = depths > camera.near
    if movers.weights[~before].sum() > LEFT_OUT:
        return None
    (left, right), (top, bottom) = (_middle(pixels[before, axis], movers.weights[before]) for axis in (0, 1))
    across, down = max(1.0, MARGIN * (right - left)), max(1.0, MARGIN * (bottom - top))
    return left - across, top - down, right + across, bottom + down


def _middle(values: Doubles, weights: Doubles) -> tuple[float, float]:
    """Return the values between which all weight lies but LEFT_OUT on each side."""
    order = np.argsort(values)
    share = np.cumsum(weights[order]) / weights.sum()
    last = len(values) - 1
    low, high = np.searchsorted(share, (LEFT_OUT, 1 - LEFT_OUT))
    return float(values[order[min(low, last)]]), float(values[order[min(high, last)]])


def _cost(camera: Camera, box: tuple[float, float, float, float], aspect: float) -> float:
    """Return how poorly a screen of an aspect shows the box: nothing for one that fills it inside the picture."""
    left, top, right, bottom = box
    # The largest part of the picture of that aspect, or what holds the box.
    height = max(min(camera.height, camera.width / aspect), bottom - top, (right - left) / aspect)
    width = height * aspect
    x, y = _place(left, right, width, camera.width), _place(top, bottom, height, camera.height)
    across = max(0.0, min(camera.width, x + width) - max(0.0, x))
    down = max(0.0, min(camera.height, y + height) - max(0.0, y))
    uncovered = 1 - across * down / (width * height)
    small = 1 - max((right - left) / width, (bottom - top) / height)
    aside = abs((left + right) / 2 - (x + width / 2)) / width
    return uncovered + 0.3 * small + 0.3 * aside


def _place(low: float, high: float, size: float, picture: float) -> float:
    """Return the start of a window of a size: with the box in its middle, moved into the picture as far as possible."""
    start = (low + high - size) / 2
    start = min(max(start, min(0.0, picture - size)), max(0.0, picture - size))
    return min(max(start, high - size), low)
