"""Scores of larger pictures and of nearer eyes: whether a scene looks as it was trained on a finer screen."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import avg_pool2d

from hgs_core.base.errors import InputError
from hgs_core.capture.capture import Capture
from hgs_core.codec import Manifest
from hgs_core.evaluate.truth import Truth
from hgs_core.metrics.psnr import psnr
from hgs_core.render.moment import moment_of_dynamic
from hgs_core.render.scene_picture import scene_picture
from hgs_core.render.types import Render
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import HybridScene

__all__ = ["LARGEST_MAGNIFICATION", "WALKS", "MagnifiedScorer", "depth_of_movers", "walked"]

LARGEST_MAGNIFICATION = 8
WALKS = (1 / 3, 2 / 3)
"""Shares of the way from a camera to the movers."""

_MOMENTS = 5  # pictures per camera
_SEEN = 0.5  # alpha from which on a pixel has a depth
_SAME_SURFACE = 0.02  # difference of depths, in parts of the depth


@dataclass(frozen=True)
class MagnifiedScorer:
    """A decoded scene, and the truth of its pictures."""

    scene: HybridScene[Tensor]
    manifest: Manifest
    capture: Capture
    source: Truth
    backend: str

    def scores(self, cameras: Sequence[int], factors: Sequence[int]) -> dict[str, Any]:
        """Return the field `magnified` of eval.json: means of dB over cameras and moments (docs/evaluation.md).

        Raises:
            InputError: a factor that is not a whole number from 2 to 8.
        """
        for factor in factors:
            if not 2 <= factor <= LARGEST_MAGNIFICATION:
                raise InputError(
                    "--magnify",
                    f"{factor} is not a whole number from 2 to {LARGEST_MAGNIFICATION}",
                    "try --magnify 2,4",
                )
        frames = np.unique(np.linspace(0, len(self.capture.times) - 1, _MOMENTS).round().astype(int))
        found: dict[str, list[float]] = {}
        for index in cameras:
            for frame in frames:
                for name, decibels in self._picture(index, int(frame), factors).items():
                    found.setdefault(name, []).append(decibels)
        return {name: float(np.mean(values)) for name, values in found.items()}

    def _picture(self, index: int, frame: int, factors: Sequence[int]) -> Mapping[str, float]:
        """Score one moment of one camera."""
        name = self.capture.cameras[index].name
        camera = next(camera for camera in self.manifest.cameras if camera.name == name)
        seconds = self.capture.moment(index, frame)
        plain, truth = self._drawn(camera, seconds), self.source.picture(index, frame)
        shown = plain.rgb.clamp(0, 1)
        scores = {"psnr": psnr(shown, truth)}
        for factor in factors:
            larger = avg_pool2d(self._drawn(camera.scaled(factor), seconds).rgb.clamp(0, 1)[None], factor)[0]
            scores |= {f"psnr_{factor}x": psnr(larger, truth), f"agreement_{factor}x": psnr(larger, shown)}
        way = depth_of_movers(self.scene, camera, seconds, self.manifest.center)
        for step, share in enumerate(WALKS, start=1):
            nearer = walked(camera, share, way)
            agreement = _agreement(camera, plain, nearer, self._drawn(nearer.scaled(2), seconds), 2)
            if agreement is not None:
                scores[f"agreement_walked_{step}_of_3"] = agreement
        return scores

    def _drawn(self, camera: Camera, seconds: float) -> Render:
        return scene_picture(self.scene, camera, seconds, rig=self.manifest.rig, backend=self.backend, depth=True)


def depth_of_movers(scene: HybridScene[Tensor], camera: Camera, seconds: float, center: Sequence[float]) -> float:
    """Return the median depth of the movers in a camera's picture, else that of the scene's centre; world units."""
    segment = scene.segment_at(seconds)
    moment = moment_of_dynamic(segment.dynamic, segment.normalised(seconds))
    points = moment.means[moment.opacities > _SEEN].numpy()
    pixels, depths = camera.project(points if len(points) else np.array([center]))
    inside = camera.shows(pixels, depths)
    if not inside.any():
        return max(camera.near, float(camera.project(np.array([center]))[1][0]))
    return float(np.median(depths[inside]))


def walked(camera: Camera, share: float, way: float) -> Camera:
    """Return the camera moved along its axis by a share of the way to a depth, world units.

    Its near plane comes nearer in proportion, as a viewer's does: else it would cut open what the camera walks to.
    """
    pose = camera.world_to_camera.copy()
    pose[2, 3] -= share * way
    return dataclasses.replace(camera, world_to_camera=pose, near=camera.near * (1 - share))


def _agreement(camera: Camera, plain: Render, nearer: Camera, drawn: Render, factor: int) -> float | None:
    """Return the PSNR of a nearer picture, averaged over the pixels of `plain` that show its surfaces, if any.

    `drawn` is `factor` times as large as `nearer`, so that every pixel of `plain` receives several of its own.
    """
    assert plain.depth is not None
    assert drawn.depth is not None
    large = nearer.scaled(factor)
    rows, columns = torch.nonzero(drawn.alpha > _SEEN, as_tuple=True)
    depths = (drawn.depth / drawn.alpha)[rows, columns].double().numpy()
    middles = np.stack([columns.numpy() + 0.5, rows.numpy() + 0.5], 1)
    points = nearer.position + large.rays(middles) * depths[:, None]
    pixels, far = camera.project(points)
    inside = camera.shows(pixels, far)
    x, y = pixels[inside].astype(np.int64).T
    cell = y * camera.width + x
    surface = (plain.depth / plain.alpha.clamp_min(1e-6)).double().numpy().ravel()[cell]
    same = np.abs(far[inside] - surface) <= _SAME_SURFACE * surface
    cell, colours = cell[same], drawn.rgb.clamp(0, 1)[:, rows, columns].double().numpy()[:, inside][:, same]
    counts = np.bincount(cell, minlength=camera.width * camera.height)
    whole = counts >= factor * factor  # a pixel at a rim has too few
    if not whole.any():
        return None
    means = np.stack([np.bincount(cell, channel, minlength=len(counts))[whole] / counts[whole] for channel in colours])
    expected = plain.rgb.clamp(0, 1).double().numpy().reshape(3, -1)[:, whole]
    return float(-10 * np.log10(max(1e-12, ((means - expected) ** 2).mean())))
