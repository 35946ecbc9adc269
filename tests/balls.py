"""Textured balls before a ring of cameras: something to find, at a known place."""

from __future__ import annotations

import numpy as np
import torch

from hgs_core.render import rasterize
from hgs_core.scene.splats import StaticSplats
from tests.synthetic import ring_of_cameras

__all__ = ["BALL", "CAMERAS", "RADIUS", "balls", "pictures", "truths"]

CAMERAS = ring_of_cameras(6, 128, 96)
BALL = np.array([0.2, 0.1, -0.1])
RADIUS = 0.25


def balls(*places: np.ndarray) -> StaticSplats[torch.Tensor]:
    """Textured balls: red, green and blue splats on a sphere."""
    count = 200
    i = np.arange(count)
    polar, around = np.arccos(1 - 2 * (i + 0.5) / count), np.pi * (1 + 5**0.5) * i
    shell = np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], 1) * RADIUS
    means = np.concatenate([place + shell for place in places])
    colours = np.eye(3)[np.random.default_rng(0).integers(0, 3, count)]
    total = len(means)
    return StaticSplats(
        torch.tensor(means, dtype=torch.float32),
        torch.full((total, 3), float(np.log(0.03))),
        torch.tensor([[1.0, 0, 0, 0]]).repeat(total, 1),
        torch.full((total,), 4.0),
        torch.tensor(np.tile(colours, (len(places), 1)), dtype=torch.float32),
    )


def pictures(static: StaticSplats[torch.Tensor] | None, grey: float = 0.2) -> list[torch.Tensor]:
    """The cameras' pictures before a grey background."""
    return [rasterize(static, None, c, gradients="none", background=(grey, grey, grey)).rgb for c in CAMERAS]


def truths(static: StaticSplats[torch.Tensor]) -> list[np.ndarray]:
    return [(p.clamp(0, 1).permute(1, 2, 0).numpy() * 255).round().astype(np.uint8) for p in pictures(static)]
