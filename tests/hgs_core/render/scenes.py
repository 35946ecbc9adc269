"""Random scenes and cameras for the rendering tests."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.scene.camera import Camera


def camera(width: int = 40, height: int = 24) -> Camera:
    """A camera near the origin, turned a little, with its principal point off the centre."""
    angle = 0.1
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    pose[:3, 3] = 0.1, -0.2, 0.3
    return Camera("test", width, height, 0.9 * width, 0.95 * width, 0.47 * width, 0.55 * height, pose)


def static_splats(count: int, seed: int = 0, dtype: torch.dtype = torch.float64) -> StaticSplats[Tensor]:
    """Splats in and around the view of `camera`, some of them opaque, overlapping or beyond the edges."""
    r = np.random.default_rng(seed)
    z = r.uniform(1.0, 6.0, count)
    means = np.stack([r.uniform(-0.8, 0.8, count) * z, r.uniform(-0.5, 0.5, count) * z, z], 1)
    arrays = (
        means,
        np.log(r.uniform(0.02, 0.3, (count, 3))),
        r.normal(size=(count, 4)),
        r.normal(0.5, 2.0, count),
        r.uniform(size=(count, 3)),
    )
    return StaticSplats(*(torch.tensor(array, dtype=dtype) for array in arrays))


def dynamic_splats(
    count: int, seed: int = 1, dtype: torch.dtype = torch.float64, coefficients: int = 4
) -> DynamicSplats[Tensor]:
    """Splats that move, turn, appear and vanish in the view of `camera`."""
    still = static_splats(count, seed)
    r = np.random.default_rng(seed + 1)
    motion = np.concatenate([still.means.numpy()[:, None], r.normal(0, 0.3, (count, coefficients - 1, 3))], 1)
    rotation = np.stack([still.quats.numpy(), r.normal(0, 0.5, (count, 4))], 1)
    arrays = (
        motion,
        rotation,
        still.log_scales,
        still.opacity_logits,
        r.uniform(0, 1, count),
        r.uniform(0, 4, count),
        still.rgb,
    )
    return DynamicSplats(*(torch.as_tensor(array).to(dtype) for array in arrays))
