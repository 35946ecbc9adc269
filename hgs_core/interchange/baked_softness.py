"""The softness of training pictures baked into splats, for viewers that have neither antialiasing nor magnification."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.interchange.smoothing_filter import widened
from hgs_core.scene.camera import Camera
from hgs_core.scene.low_pass import COMPENSATION_MIN, LOW_PASS
from hgs_core.scene.motion import position
from hgs_core.scene.rotations import matrices, unit_quaternions
from hgs_core.scene.splats import HybridScene, Segment

__all__ = ["with_baked_softness"]

BESIDE = 0.1  # share of a picture's sides around it in which a splat's centre still counts as shown


def with_baked_softness(scene: HybridScene[Floats], rig: Sequence[Camera]) -> HybridScene[Floats]:
    """Return a scene to be drawn without antialiasing that looks about as `scene` does with it, on larger screens too.

    Splats grow by the low-pass of the rig's finest picture of them, as with Mip-Splatting's 3D filter (Yu et al., 2024,
    section 5.1). Opacities, learnt with the screen's compensation, fade by its mean over the cameras that show them.
    Dynamic splats are taken at the middle of their lives. Splats that no camera shows stay as they are.
    """
    s = scene.static
    scales, logits = _softened(
        s.means.astype(np.float64), s.log_scales, s.quats, s.opacity_logits, rig, scene.antialiased
    )
    static = dataclasses.replace(s, log_scales=scales, opacity_logits=logits)
    segments = []
    for segment in scene.segments:
        d = segment.dynamic
        offsets = (np.clip(d.time_centers, 0, 1) - d.time_centers).astype(np.float64)[:, None]
        places: Doubles = position(d.motion.astype(np.float64), offsets)
        turns = d.rotation[:, 0] + offsets * d.rotation[:, 1]
        scales, logits = _softened(places, d.log_scales, turns, d.opacity_logits, rig, scene.antialiased)
        dynamic = dataclasses.replace(d, log_scales=scales, opacity_logits=logits)
        segments.append(Segment(segment.start, segment.end, dynamic))
    return dataclasses.replace(scene, static=static, segments=tuple(segments), antialiased=False)


def _softened(
    places: Doubles, log_scales: Floats, quats: Floats | Doubles, logits: Floats, rig: Sequence[Camera], faded: bool
) -> tuple[Floats, Floats]:
    """Return log-scales [K, 3] and opacity logits [K]."""
    axes = matrices(unit_quaternions(np.asarray(quats, np.float64))) * np.exp(log_scales.astype(np.float64))[:, None, :]
    factors, shown = np.zeros(len(places)), np.zeros(len(places))
    spacing = np.full(len(places), np.inf)  # world units per pixel
    for camera in rig:
        pixels, depth = camera.project(places)
        inside = camera.shows(pixels, depth, beside=BESIDE)
        sharp, blurred = _determinants(camera, places[inside], axes[inside])
        factors[inside] += np.sqrt(np.maximum(COMPENSATION_MIN**2, sharp / blurred))
        shown += inside
        spacing[inside] = np.minimum(spacing[inside], depth[inside] / max(camera.fx, camera.fy))
    seen = shown > 0
    scales = widened(log_scales.astype(np.float64), math.sqrt(LOW_PASS) * np.where(seen, spacing, 0.0))
    if not faded:
        return scales.astype(np.float32), logits
    opacity = 1 / (1 + np.exp(-logits.astype(np.float64))) * np.where(seen, factors / np.maximum(shown, 1), 1.0)
    opacity = np.clip(opacity, 1e-6, 1 - 1e-6)
    return scales.astype(np.float32), np.log(opacity / (1 - opacity)).astype(np.float32)


def _determinants(camera: Camera, places: Doubles, axes: Doubles) -> tuple[Doubles, Doubles]:
    """Return the determinants [K] of the screen covariance without and with the low-pass, pixels to the fourth."""
    R, shift = camera.world_to_camera[:3, :3], camera.world_to_camera[:3, 3]
    x, y, z = (places @ R.T + shift).T
    turned = R @ axes  # [K, 3, 3]
    across = (turned[:, 0] - (x / z)[:, None] * turned[:, 2]) * (camera.fx / z)[:, None]
    down = (turned[:, 1] - (y / z)[:, None] * turned[:, 2]) * (camera.fy / z)[:, None]
    sharp = (np.cross(across, down) ** 2).sum(axis=1)
    traces = (across**2).sum(axis=1) + (down**2).sum(axis=1)
    return sharp, sharp + LOW_PASS * traces + LOW_PASS**2
