"""The share of a view that a scene's cameras saw well enough, by which a new place to look from is trusted.

A camera saw a place that lies inside its picture and not behind what a small picture of the scene shows there. A place
is seen well from an eye if at least two cameras saw it, the eye looks at it from their side or a little beyond, and is
not much nearer than the nearest of them: so walls from behind, the inside of bodies and smears do not count. The share
of a view is the weight in its pixels of the splats that are seen well. Where a pixel has weight left the scene may be
black: that counts, too, if the place that the pixel shows is seen well; where it shows nothing, the place is taken at
the far side of the picture.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.render.rasterize import rasterize
from hgs_core.render.threads import one_torch_thread
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene
from hgs_core.scene.temporal import evaluate

__all__ = ["SeenShare"]

WITNESSES = 2  # cameras
BEYOND = math.radians(30)  # angle of the eye beyond the cone of the cameras
NEARER = 0.5  # least distance of the eye as a share of the nearest camera's
REACH = 2.0  # standard deviations from a splat's surface to its centre
BEHIND = 1.05  # largest depth of a place in the open as a share of the picture's depth
SOMETHING = 0.1  # least alpha of a pixel with something to see
COVERED = 0.98  # least alpha of a pixel without weight left
FAR_SIDE = 0.9  # quantile of the depths of a picture
CAMERA_SIDE, EYE_SIDE = 96, 48  # pixels of a small picture's longer side, at most

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class _Picture:
    red: Doubles  # [H, W]
    alpha: Doubles  # [H, W]
    depth: Doubles  # [H, W] infinite where there is nothing


@dataclass(frozen=True)
class _Seen:
    """The cone of the cameras that saw each of P places."""

    axis: Floats  # [P, 3] unit vectors towards the cameras
    cosine: Floats  # [P] of the largest angle to an eye, above 1 where too few cameras saw the place
    nearest: Floats  # [P] least distance of an eye


class SeenShare:
    """A scene in the middle of its time as its cameras saw it."""

    def __init__(self, scene: HybridScene[Floats], cameras: Sequence[Camera]) -> None:
        """Draw the small pictures of the cameras, of which there is at least one."""
        seconds = (scene.start + scene.end) / 2
        segment = scene.segment_at(seconds)
        self._moment, self._antialiased = segment.normalised(seconds), scene.antialiased
        self._static, self._dynamic = scene.static.map(torch.from_numpy), segment.dynamic.map(torch.from_numpy)
        self._cameras = [camera.within(CAMERA_SIDE) for camera in cameras]
        self._shown = [self._draw(camera).depth for camera in self._cameras]
        moving, _, _ = evaluate(segment.dynamic, self._moment)
        self._places = np.concatenate([scene.static.means, moving]).astype(np.float32)
        sizes = np.concatenate([scene.static.log_scales, segment.dynamic.log_scales]).max(axis=1, initial=-np.inf)
        self._reach = REACH * np.exp(np.minimum(sizes, 30).astype(np.float64))
        self._seen = self._seen_by_cameras(self._places, self._reach)

    @property
    def filled(self) -> float:
        """The share of the cameras' pictures that shows something."""
        return float(np.mean([np.isfinite(depth).mean() for depth in self._shown]))

    def of(self, eye: Camera) -> float:
        """Return the share of the view of an eye."""
        eye = eye.within(EYE_SIDE)
        well = _well(self._seen, self._places, eye)
        picture = self._draw(eye, _red(well))
        return float((picture.red + self._rest(eye, picture)).mean())

    def twice(self, angle: float) -> float:
        """Return the share of the static splats in the cameras' pictures with a second view within `angle`, radians.

        1 without static splats.
        """
        still = len(self._static)
        towards = np.zeros((len(self._cameras), still, 3), np.float32)
        for one, (rows, direction, _) in zip(
            towards, self._views(self._places[:still], self._reach[:still]), strict=True
        ):
            one[rows] = direction
        again = np.zeros(still, np.bool_)
        for one, other in itertools.combinations(towards, 2):
            again |= np.einsum("ij,ij->i", one, other) >= math.cos(angle)
        moving = np.zeros(len(self._places) - still)
        shown, seen = (
            sum(
                float(self._draw(camera, _red(np.concatenate([weights, moving]))).red.sum()) for camera in self._cameras
            )
            for weights in (np.ones(still), again)
        )
        return seen / shown if shown else 1.0

    def _rest(self, eye: Camera, picture: _Picture) -> Doubles:
        """Return the weight left in each pixel [H, W] where the place behind it is seen well."""
        rest = np.where(picture.alpha < COVERED, 1 - picture.alpha, 0)
        known = np.isfinite(picture.depth)
        if not known.any():
            return np.zeros_like(rest)
        row, column = np.nonzero(rest)
        depth = np.where(known, picture.depth, np.quantile(picture.depth[known], FAR_SIDE))[row, column]
        places = eye.position + eye.rays(np.stack([column, row], 1) + 0.5) * depth[:, None]
        seen = self._seen_by_cameras(places, np.zeros(len(places)))
        rest[row, column] *= _well(seen, places.astype(np.float32), eye)
        return rest

    def _seen_by_cameras(self, places: NDArray[np.floating[Any]], reach: Doubles) -> _Seen:
        """Return how the cameras saw places [P, 3], each reaching so far [P] towards them."""
        count, axis = np.zeros(len(places)), np.zeros((len(places), 3))
        nearest = np.full(len(places), np.inf)
        towards = []
        for rows, direction, distance in self._views(places, reach):
            towards.append((rows, direction))
            count[rows] += 1
            axis[rows] += direction
            nearest[rows] = np.minimum(nearest[rows], distance)
        axis /= np.maximum(np.linalg.norm(axis, axis=1), 1e-9)[:, None]
        cosine = np.ones(len(places))
        for rows, direction in towards:
            cosine[rows] = np.minimum(cosine[rows], (axis[rows] * direction).sum(axis=1))
        widest = np.cos(np.minimum(np.arccos(np.clip(cosine, -1, 1)) + BEYOND, math.pi))
        widest[count < min(WITNESSES, len(self._cameras))] = 2
        return _Seen(axis.astype(np.float32), widest.astype(np.float32), (NEARER * nearest).astype(np.float32))

    def _views(
        self, places: NDArray[np.floating[Any]], reach: Doubles
    ) -> Iterator[tuple[NDArray[np.int64], Doubles, Doubles]]:
        """Return for each camera the places [K] that it saw, the directions [K, 3] and the distances [K] to it."""
        for camera, shown in zip(self._cameras, self._shown, strict=True):
            pixels, depth = camera.project(places)
            rows = np.flatnonzero(camera.shows(pixels, depth, beyond=0))
            column, row = pixels[rows].astype(np.int64).T
            rows = rows[depth[rows] - reach[rows] <= BEHIND * shown[row, column]]
            offset = camera.position - places[rows]
            distance = np.linalg.norm(offset, axis=1)
            yield rows, offset / distance[:, None], distance

    def _draw(self, camera: Camera, rgb: Tensor | None = None) -> _Picture:
        """Draw the scene, its splats in colours [N + M, 3] if they are given."""
        static, dynamic = self._static, self._dynamic
        if rgb is not None:
            static = dataclasses.replace(static, rgb=rgb[: len(static)])
            dynamic = dataclasses.replace(dynamic, rgb=rgb[len(static) :])
        with one_torch_thread():
            drawn = rasterize(
                static,
                dynamic,
                camera,
                self._moment,
                gradients="none",
                antialiased=self._antialiased,
                depth=True,
            )
        assert drawn.depth is not None
        depth, alpha = drawn.depth.double().numpy(), drawn.alpha.double().numpy()
        there = alpha >= SOMETHING
        return _Picture(
            drawn.rgb[0].double().numpy(), alpha, np.where(there, depth / np.where(there, alpha, 1), np.inf)
        )


def _red(weights: NDArray[Any]) -> Tensor:
    """Return colours [P, 3] with weights [P] in each channel."""
    return torch.from_numpy(weights.astype(np.float32)[:, None].repeat(3, axis=1))


def _well(seen: _Seen, places: Floats, eye: Camera) -> Flags:
    """Return which places [P, 3] are seen well from an eye."""
    offset = eye.position.astype(np.float32) - places
    distance = np.sqrt(np.einsum("ij,ij->i", offset, offset))
    aligned = np.einsum("ij,ij->i", offset, seen.axis) >= seen.cosine * distance
    return np.asarray(aligned & (distance >= seen.nearest))
