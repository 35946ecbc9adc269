"""Scenes to edit, and pictures of them."""

from __future__ import annotations

import dataclasses

import numpy as np
import torch

from hgs_core.edit.viewed_scene import ViewedScene
from hgs_core.render.rasterize import rasterize
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats
from hgs_core.scene.camera import Camera
from tests.synthetic import ring_of_cameras

SPANS = ((2.0, 3.6), (3.7, 5.3))  # seconds of the segments: the first is shown until the second starts
CAMERAS = tuple(ring_of_cameras(3, 64, 48))


def statics(rng: np.random.Generator, count: int = 120) -> StaticSplats[np.ndarray]:
    arrays = (
        rng.uniform(-1, 1, (count, 3)),
        np.log(rng.uniform(0.03, 0.25, (count, 3))),
        rng.normal(size=(count, 4)),
        rng.normal(1, 2, count),
        rng.uniform(0, 1, (count, 3)),
    )
    return StaticSplats(*(array.astype(np.float32) for array in arrays))


def dynamics(rng: np.random.Generator, count: int = 60, coefficients: int = 4) -> DynamicSplats[np.ndarray]:
    still = statics(rng, count)
    motion = rng.normal(0, 0.5, (count, coefficients, 3)).astype(np.float32)
    rotation = np.stack([still.quats, rng.normal(size=(count, 4)).astype(np.float32)], axis=1)
    centers, precisions = rng.uniform(-0.1, 1.1, count), rng.uniform(-4, 9, count)
    return DynamicSplats(
        motion,
        rotation,
        still.log_scales,
        still.opacity_logits,
        centers.astype(np.float32),
        precisions.astype(np.float32),
        still.rgb,
    )


def moving(seed: int = 0, coefficients: int = 4, antialiased: bool = False) -> ViewedScene:
    """Two segments of splats that fly, turn, come and go."""
    rng = np.random.default_rng(seed)
    segments = tuple(Segment(start, end, dynamics(rng, coefficients=coefficients)) for start, end in SPANS)
    scene = HybridScene(statics(rng), segments, (0.2, 0.1, 0.3), antialiased)
    return ViewedScene(scene, CAMERAS, 2.0 + np.arange(34) / 10, (0.0, -1.0, 0.0))


def still(seed: int = 5) -> ViewedScene:
    """Splats that never change, before the background of `moving`."""
    scene = HybridScene(
        statics(np.random.default_rng(seed)), (Segment(0.0, 0.0, DynamicSplats.empty()),), (0.2, 0.1, 0.3)
    )
    return ViewedScene(scene, CAMERAS[:1], np.zeros(1), (0.0, -1.0, 0.0))


def picture(viewed: ViewedScene, camera: Camera, seconds: float) -> np.ndarray:
    """The reference rasterizer's picture, float64, [3, H, W]."""
    scene = viewed.scene.map(lambda array: torch.from_numpy(np.asarray(array, np.float64)))
    segment = scene.segment_at(seconds)
    drawn = rasterize(
        scene.static,
        segment.dynamic,
        camera,
        segment.normalised(seconds),
        backend="reference",
        gradients="none",
        background=scene.background,
        antialiased=scene.antialiased,
    )
    return drawn.rgb.numpy()


def splats(viewed: ViewedScene) -> int:
    return len(viewed.scene.static) + viewed.scene.dynamic_splats


def with_static(viewed: ViewedScene, **changed: np.ndarray) -> ViewedScene:
    scene = dataclasses.replace(viewed.scene, static=dataclasses.replace(viewed.scene.static, **changed))
    return dataclasses.replace(viewed, scene=scene)
