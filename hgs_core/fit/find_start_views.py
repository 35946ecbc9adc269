"""The choice of a scene's first views: cameras that show all movers of the first seconds."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from hgs_core.base.arrays import Doubles
from hgs_core.codec.format.start_views import StartView, StartViews
from hgs_core.render.contributions import contributions
from hgs_core.render.moment import moment_of_dynamic
from hgs_core.render.scene_picture import scene_picture
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["find_start_views"]

SECONDS = 2.0  # stretch from the scene's start
MOMENTS = 4  # moments looked at
SIDE = 160  # pixels; longer side of the pictures that weigh movers
WIDE, TALL = 16 / 10, 390 / 844  # width over height of a desktop's window and of a phone held upright
LEFT_OUT = 0.01  # weight of movers beyond each side of a box
MARGIN = 0.04  # room around the movers, in parts of the box
SLIGHT = 0.02  # share of a screen

Box = tuple[float, float, float, float]
"""Left, top, right and bottom, pixels."""


@dataclass(frozen=True)
class _Movers:
    points: Doubles  # [K, 3] world units
    weights: Doubles  # [K] visible area, world units squared; their sum is 1


def find_start_views(scene: HybridScene[NDArray[np.float32]], cameras: Sequence[Camera]) -> StartViews | None:
    """Return the views that show all movers, and show them large; None where nothing moves in the first seconds.

    A box holds all movers but those that hardly show. Where it does not fit into the picture of a camera, it also holds
    what the scene shows beside the picture. The views with the least beside the picture and with the least background
    win, then the largest movers in the middle, then cameras in the middle of the rig.
    """
    tensors = scene.map(torch.from_numpy)
    movers = _movers(tensors, cameras)
    if movers is None:
        return None
    places = np.array([camera.position for camera in cameras])
    away = np.linalg.norm(places - places.mean(axis=0), axis=1)
    off_centre = away / max(away.max(), 1e-12)
    boxes = [_box(camera, movers) for camera in cameras]
    if not any(boxes):
        return None

    def best(aspect: float) -> StartView:
        found = []
        for camera, box, aside in zip(cameras, boxes, off_centre, strict=True):
            if box is not None:
                cost, whole = _framed(tensors, camera, box, aspect)
                found.append((cost + 0.1 * aside, StartView(camera.name, whole)))
        return min(found, key=lambda one: one[0])[1]

    return StartViews(best(WIDE), best(TALL))


def _movers(scene: HybridScene[Tensor], cameras: Sequence[Camera]) -> _Movers | None:
    """Return the moving splats of the first seconds, weighted by the area that the cameras see of them."""
    still = len(scene.static)
    points, weights = [], []
    for seconds in np.linspace(scene.start, min(scene.end, scene.start + SECONDS), MOMENTS):
        segment = scene.segment_at(float(seconds))
        if len(segment.dynamic) == 0:
            continue
        moment = segment.normalised(float(seconds))
        place = moment_of_dynamic(segment.dynamic, moment).means.numpy()
        seen = np.zeros(len(place))
        for camera in cameras:
            small = camera.within(SIDE)
            shown = contributions(scene.static, segment.dynamic, small, moment, antialiased=scene.antialiased)
            _, depth = small.project(place)
            seen += shown.total[still:] * (np.maximum(depth, 0) / small.fx) ** 2
        points.append(place[seen > 0])
        weights.append(seen[seen > 0])
    if not points or not any(len(place) for place in points):
        return None
    joined = np.concatenate(weights)
    return _Movers(np.concatenate(points), joined / joined.sum())


def _box(camera: Camera, movers: _Movers) -> Box | None:
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


def _framed(scene: HybridScene[Tensor], camera: Camera, box: Box, aspect: float) -> tuple[float, Box]:
    """Return how poorly a screen of an aspect shows a box, and the box to keep in view there.

    The cost is 0 for a box that fills a screen inside the picture. The share of the screen beside the picture counts
    half where the scene covers it, and wholly where the background shows.
    """
    left, top, right, bottom = box
    # The largest part of the picture of that aspect, or the smallest part of its plane that holds the box.
    height = max(min(camera.height, camera.width / aspect), bottom - top, (right - left) / aspect)
    width = height * aspect
    shown = []
    for x in _places(left, right, width, camera.width):
        for y in _places(top, bottom, height, camera.height):
            across = max(0.0, min(camera.width, x + width) - max(0.0, x))
            down = max(0.0, min(camera.height, y + height) - max(0.0, y))
            beside = 1 - across * down / (width * height)
            missing = 0.0 if beside < SLIGHT else 1 - _covered(scene, camera, (x, y, width, height))
            shown.append((beside / 2 + missing, x, y))
    cost, x, y = min(shown)
    small = 1 - max((right - left) / width, (bottom - top) / height)
    aside = abs((left + right) / 2 - (x + width / 2)) / width
    whole = (x, y, x + width, y + height) if cost > SLIGHT else box
    return cost + 0.3 * small + 0.3 * aside, whole


def _places(low: float, high: float, size: float, picture: float) -> list[float]:
    """Return the starts of a window that holds a stretch: a single one inside the picture, or several beyond it."""
    middle = (low + high - size) / 2
    if size <= picture:
        middle = min(max(middle, 0.0), picture - size)
        return [min(max(middle, high - size), low)]
    first, last = max(high - size, min(low, picture - size)), min(low, max(high - size, 0.0))
    return [first, min(max(middle, first), last), last]


def _covered(scene: HybridScene[Tensor], camera: Camera, window: Box) -> float:
    """Return the mean alpha of a window (left, top, width, height) in the plane of a picture, at the scene's start."""
    x, y, width, height = window
    scale = SIDE / max(width, height)
    part = dataclasses.replace(
        camera,
        width=max(1, round(width * scale)),
        height=max(1, round(height * scale)),
        fx=camera.fx * scale,
        fy=camera.fy * scale,
        cx=(camera.cx - x) * scale,
        cy=(camera.cy - y) * scale,
    )
    return float(scene_picture(scene, part, scene.start, rig=(camera,)).alpha.mean())
