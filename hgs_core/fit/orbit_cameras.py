"""Cameras for a scene that came without any: around the whole of it, and closer to every part.

A file of splats says nothing of who looks at them. That "up" is -y, as the first camera of a COLMAP reconstruction has
it, is a convention, and that it looks along z from the front. But many files are turned about y. Densification puts
splats where photographs show detail, and most are taken of the front: a side from which clearly more splats are seen is
taken for it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch

from hgs_core.base import morton
from hgs_core.base.arrays import Doubles, Floats
from hgs_core.fit.detail_cameras import DIRECTIONS, best_directions, detail_distances
from hgs_core.fit.standpoints import standpoints
from hgs_core.render.contributions import contributions
from hgs_core.render.threads import one_torch_thread
from hgs_core.scene.camera import Camera, looking_at
from hgs_core.scene.opacities import opacities_of
from hgs_core.scene.splats import HybridScene
from hgs_core.scene.temporal import evaluate, lifetime

__all__ = ["OrbitCameras", "orbit_cameras"]

SIZE = (640, 480)  # pixels
FOCAL = 560.0
DISTANCE = 2.65  # radii; a ball there fills 0.96 of a picture's height
NEAR = 0.2  # share of the distance to a camera's target
RINGS = (("", 8, 10.0), ("high", 6, 45.0), ("low", 4, -30.0), ("top", 1, 85.0), ("bottom", 1, -85.0))
"""Cameras around the whole: their name, their number and their elevation in degrees; the first ring begins in front."""

SIDES = ("front", "front-right", "right", "back-right", "back", "back-left", "left", "front-left")
CLOSER, CLOSER_SHARE = 20, 0.5  # cameras, and their distance in those of the whole
DETAIL = 20  # cameras that stand where splats are as large as training leaves them
NEAREST_SHARE = 0.2  # least share of the way to a wall
COARSE = 4  # reduction of pictures for counting splats
INNER = 0.98  # share of all opacity; splats beyond `OUTLYING` times its distance may be out of frame
OUTLYING = 1.5
GIANT = 4.0  # balls of all places, or splats of the usual size: what reaches farther is no measure of a scene
REACH = 2.0  # standard deviations of a splat that belong to it
MOMENTS = (0.0, 0.5, 1.0)  # moments of a visible life
CLEARLY_MORE = 1.05
SHOWN = 1 / 255  # the least weight of a pixel with which a splat counts as seen
UNHIDDEN = 0.3  # the least of one that is not behind others
MOST = 0.5  # share of the sight inside
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


@dataclass(frozen=True)
class OrbitCameras:
    """Made-up cameras."""

    whole: tuple[Camera, ...]  # show the scene from all sides, the first one from its front; of a room from inside
    closer: tuple[Camera, ...]  # parts of it, from any side; of a room its outside
    detail: tuple[Camera, ...]  # close to splats of trained size, from the side that shows most


def orbit_cameras(scene: HybridScene[Floats]) -> OrbitCameras:
    """Return cameras that look at a scene from its front, its other sides, above, below, and more closely.

    Of a room, of which most that is seen inside is hidden from outside, those named are inside. What stands far outside
    of the rest (floaters) may be out of every picture.
    """
    places, sizes, weights = _places(scene)
    middle, radius = _ball(places, sizes, weights)
    distance = DISTANCE * radius
    sides = [_seen_at(middle, distance, azimuth, RINGS[0][2]) for azimuth in (0, 90, 180, 270)]
    seen = np.array([_splats_seen(scene, camera) for camera in sides])
    front = 90 * int(seen.argmax()) if seen.max() > CLEARLY_MORE * seen[0] else 0
    whole = [
        dataclasses.replace(_seen_at(middle, distance, front + 360 * i / count, elevation), name=_name(ring, count, i))
        for ring, count, elevation in RINGS
        for i in range(count)
    ]
    closer = [
        _looking(f"close{CLOSER_SHARE}-{i}", target, CLOSER_SHARE * distance * _direction(i, CLOSER))
        for i, target in enumerate(_spread(places, weights, CLOSER))
    ]
    targets = _spread(places, weights, DETAIL)
    distances = detail_distances(targets, places, _log_scales(scene), FOCAL, distance)
    inner = _inner(targets, distances, standpoints(scene, places, sizes, weights))
    if inner and _hidden_share(scene, inner, whole) > MOST:  # a room: nobody is outside
        return OrbitCameras(tuple(inner), tuple(whole), tuple(_nearer(targets, distances, inner)))
    detail = _detail(scene, targets, distances)
    if inner:
        detail = [*detail[::2], *_nearer(targets, distances, inner)[1::2]]
    return OrbitCameras(tuple(whole), tuple(closer), tuple(detail))


def _inner(targets: Doubles, distances: Doubles, stands: Doubles) -> list[Camera]:
    """Return cameras that look at targets from the places to stand, each from one about as far away as is asked for."""
    if not len(stands):
        return []
    away = np.linalg.norm(stands - targets[:, None], axis=2)  # [targets, stands]
    chosen = np.abs(np.log(np.maximum(away, 1e-9) / distances[:, None])).argmin(axis=1)
    order = np.argsort(-away[np.arange(len(targets)), chosen], kind="stable")  # the first one shows most
    return [_looking(f"inside-{i}", targets[k], stands[chosen[k]] - targets[k]) for i, k in enumerate(order)]


def _nearer(targets: Doubles, distances: Doubles, inner: Sequence[Camera]) -> list[Camera]:
    """Return cameras that look at targets along the lines of inner cameras, from as near as is asked for."""
    found: list[Camera] = []
    for target, distance in zip(targets, distances, strict=True):
        looks = [np.linalg.norm(np.cross(camera.world_to_camera[2, :3], target - camera.position)) for camera in inner]
        aside = inner[int(np.argmin(looks))].position - target
        length = float(np.linalg.norm(aside))
        share = min(1.0, distance / max(length, 1e-9))
        found.append(_looking(f"detail-{len(found)}", target, max(share, NEAREST_SHARE) * aside))
    return found


def _detail(scene: HybridScene[Floats], targets: Doubles, distances: Doubles) -> list[Camera]:
    """Return cameras that look at targets from where most splats show."""
    directions = np.array([_direction(i, DIRECTIONS) for i in range(DIRECTIONS)])

    def small(target: Doubles, aside: Doubles) -> Camera:
        return _smaller(_looking("", target, aside), COARSE)

    chosen = best_directions(targets, distances, directions, small, lambda camera: _splats_seen(scene, camera))
    return [
        _looking(f"detail-{i}", target, distance * direction)
        for i, (target, distance, direction) in enumerate(zip(targets, distances, chosen, strict=True))
    ]


def _log_scales(scene: HybridScene[Floats]) -> Floats:
    """Return the log-scales of the places of `_places`."""
    moving = [segment.dynamic.log_scales for segment in scene.segments for _ in MOMENTS]
    return np.concatenate([scene.static.log_scales, *moving])


def _smaller(camera: Camera, factor: int) -> Camera:
    return dataclasses.replace(
        camera,
        width=camera.width // factor,
        height=camera.height // factor,
        fx=camera.fx / factor,
        fy=camera.fy / factor,
        cx=camera.cx / factor,
        cy=camera.cy / factor,
    )


def _places(scene: HybridScene[Floats]) -> tuple[Doubles, Doubles, Doubles]:
    """Return where splats are [P, 3], how far they reach and how opaque they are, moving ones at several moments."""
    static = scene.static
    places, scales, logits = [static.means.astype(np.float64)], [static.log_scales], [static.opacity_logits]
    for segment in scene.segments:
        start, end = (np.clip(np.nan_to_num(side), 0, 1) for side in lifetime(segment.dynamic))
        for moment in MOMENTS:
            places.append(evaluate(segment.dynamic, start + moment * (end - start))[0])
            scales.append(segment.dynamic.log_scales)
            logits.append(segment.dynamic.opacity_logits)
    sizes = REACH * np.exp(np.concatenate(scales).astype(np.float64).max(axis=1, initial=-30.0))
    return np.concatenate(places), sizes, opacities_of(np.concatenate(logits))


def _ball(places: Doubles, sizes: Doubles, weights: Doubles) -> tuple[Doubles, float]:
    """Return middle and radius of the ball of the splats [P], but for outliers."""
    median = np.array([_quantile(axis, weights, 0.5) for axis in places.T])
    away = np.linalg.norm(places - median, axis=1)
    inner = away <= OUTLYING * _quantile(away, weights, INNER)
    middle = (places[inner].min(axis=0) + places[inner].max(axis=0)) / 2
    away = np.linalg.norm(places[inner] - middle, axis=1)
    largest = GIANT * max(float(away.max()), _quantile(sizes[inner], weights[inner], 0.5))
    reach = away + np.minimum(sizes[inner], largest)
    radius = max(float(away.max()), _quantile(reach, weights[inner], INNER))
    return middle, max(radius, 1e-9)


def _quantile(values: Doubles, weights: Doubles, share: float) -> float:
    order = np.argsort(values, kind="stable")
    total = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(total, share * total[-1])]])


def _spread(places: Doubles, weights: Doubles, count: int) -> Doubles:
    """Return the places [count, 3] of splats that stand for equal shares of all opacity, by their place in space."""
    low, high = places.min(axis=0), places.max(axis=0)
    grid = (places - low) / np.maximum((high - low).max(), 1e-30) * 0xFFFF
    order = morton.order(morton.interleave(grid.astype(np.uint32)))
    total = np.cumsum(weights[order])
    chosen = order[np.searchsorted(total, (np.arange(count) + 0.5) / count * total[-1])]
    return np.asarray(places[chosen])


def _splats_seen(scene: HybridScene[Floats], camera: Camera) -> int:
    return int((_peaks(scene, camera) >= SHOWN).sum())


def _hidden_share(scene: HybridScene[Floats], inner: Sequence[Camera], outer: Sequence[Camera]) -> float:
    """Return which share of the splats that inner cameras see is hidden from all outer ones."""
    inside, outside = (
        np.max([_peaks(scene, camera) for camera in cameras], axis=0) >= UNHIDDEN for cameras in (inner, outer)
    )
    return float((inside & ~outside).sum() / max(int(inside.sum()), 1))


def _peaks(scene: HybridScene[Floats], camera: Camera) -> Floats:
    """Return the largest weight that each splat has in a pixel of a camera, in the middle of the scene's time."""
    seconds = (scene.start + scene.end) / 2
    segment = scene.segment_at(seconds)
    with one_torch_thread():
        found = contributions(
            scene.static.map(torch.from_numpy),
            segment.dynamic.map(torch.from_numpy),
            camera,
            segment.normalised(seconds),
            antialiased=scene.antialiased,
        )
    return np.asarray(found.peak)


def _name(ring: str, count: int, number: int) -> str:
    if not ring:
        return SIDES[number]
    return ring if count == 1 else f"{ring}-{number + 1}"


def _direction(number: int, count: int) -> Doubles:
    """Return one of `count` unit vectors that are evenly spread over all directions (Fibonacci)."""
    y = 1 - (2 * number + 1) / count
    angle = GOLDEN_ANGLE * number
    across = np.sqrt(1 - y * y)
    return np.array([across * np.sin(angle), y, -across * np.cos(angle)])


def _seen_at(middle: Doubles, distance: float, azimuth: float, elevation: float) -> Camera:
    """Return a camera in degrees around the middle: azimuth 0 looks along z, 90 stands to the right of that."""
    a, e = np.deg2rad(azimuth), np.deg2rad(elevation)
    return _looking("", middle, distance * np.array([np.cos(e) * np.sin(a), -np.sin(e), -np.cos(e) * np.cos(a)]))


def _looking(name: str, target: Doubles, aside: Doubles) -> Camera:
    """Return a camera that looks at a point from a vector away."""
    distance = float(np.linalg.norm(aside))
    pose, (width, height) = looking_at(target + aside, target), SIZE
    return Camera(name, width, height, FOCAL, FOCAL, width / 2, height / 2, pose, near=NEAR * distance)
