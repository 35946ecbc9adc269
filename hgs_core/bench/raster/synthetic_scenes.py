"""Synthetic scenes with the sizes, shapes, opacities and clusters of trained ones.

The distributions are set on the screen of a 676x507 picture; a smaller or larger picture shows the same scene.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base import morton
from hgs_core.base.arrays import Floats
from hgs_core.scene.camera import Camera
from hgs_core.scene.opacities import logits_of
from hgs_core.scene.splats import DynamicSplats, StaticSplats

__all__ = ["BenchScene", "bench_camera", "bench_scene", "bench_target", "median_radius"]


WIDTH, HEIGHT = 676, 507  # pixels of the picture on which the scene is laid out
FOCAL = 0.9  # focal length in picture widths
NEAREST, FARTHEST = 2.0, 10.0  # depth of the splats, world units
CLUSTERS, CLUSTERED = 40, 0.6  # how many, and the share of the splats in them
OVERSCAN_SHARE = 0.03  # share of the picture's side, beyond each edge
RADIUS_SPREAD = 0.6  # standard deviation of ln(radius)
LARGE, LARGE_FACTOR = 0.02, 10.0  # share of the splats that are ten times as large
FAINT_SHARE = 0.55  # share of the splats in the lower of the two opacity modes
LIFE_SPAN = 0.09  # normalised time in which a dynamic splat's opacity falls to exp(-1/2) of its peak


@dataclass(frozen=True)
class BenchScene:
    """The drawn splats in the order of training: each set along a Morton curve."""

    static: StaticSplats[Floats]
    dynamic: DynamicSplats[Floats] | None  # None without a share of them
    time: float  # normalised


def median_radius(splats: int) -> float:
    """Return the median screen radius (3 sigma, major axis, before the low-pass) of a scene at 676x507, pixels.

    Training spends more splats on finer detail: 4.5 pixels for 20,000, 3 for 100,000 and 2 for 500,000.
    """
    return 4.5 * math.sqrt(math.sqrt(20_000 / splats))


def bench_camera(width: int, height: int) -> Camera:
    """Return the camera of the benchmark, a little turned: no product with its pose is one with 0 or 1."""
    turn, tilt = 0.2, -0.1
    about_y = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    about_x = [[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]]
    pose = np.eye(4)
    pose[:3, :3] = np.array(about_x) @ np.array(about_y)
    pose[:3, 3] = 0.1, -0.2, 0.3
    return Camera("bench", width, height, FOCAL * width, FOCAL * width, width / 2, height / 2, pose)


def bench_scene(splats: int, seed: int, dynamic_share: float = 0.0) -> BenchScene:
    """Make a scene.

    Args:
        splats: of both sets together.
        seed: the same seed gives the same scene.
        dynamic_share: share of them that move, 0 to 1, but one stays; about half of those are alive then.
    """
    rng = np.random.default_rng((seed, splats))
    everything = _statics(rng, splats)
    moving = min(round(splats * dynamic_share), splats - 1)
    choice = rng.permutation(splats)
    static = everything.take(choice[moving:])
    static = static.take(_along_curve(static.means))
    dynamic = None
    if moving:
        moved = everything.take(choice[:moving])
        dynamic = _dynamics(rng, moved.take(_along_curve(moved.means)))
    return BenchScene(static, dynamic, 0.5)


def bench_target(camera: Camera, seed: int) -> Floats:
    """Return a smooth random picture [3, H, W] in [0, 1] for the loss to compare with."""
    rng = np.random.default_rng((seed, camera.width, camera.height))
    y, x = np.meshgrid(np.arange(camera.height) / camera.height, np.arange(camera.width) / camera.width, indexing="ij")
    picture = np.zeros((3, camera.height, camera.width))
    for channel in picture:
        for _ in range(4):
            across, down = rng.uniform(-12, 12, 2)
            channel += np.sin(across * x + down * y + rng.uniform(0, 2 * np.pi)) / 8
    return (picture + 0.5).astype(np.float32)


def _statics(rng: np.random.Generator, count: int) -> StaticSplats[Floats]:
    side = np.array([WIDTH, HEIGHT])
    cluster = rng.integers(0, CLUSTERS, count)
    centres, spreads = rng.uniform((0, 0), side, (CLUSTERS, 2)), rng.uniform(0.03, 0.15, CLUSTERS) * WIDTH
    depths = rng.uniform(NEAREST, FARTHEST, CLUSTERS)
    clustered = rng.random(count) < CLUSTERED
    pixels = np.where(
        clustered[:, None],
        centres[cluster] + rng.normal(size=(count, 2)) * spreads[cluster, None],
        rng.uniform(-OVERSCAN_SHARE * side, (1 + OVERSCAN_SHARE) * side, (count, 2)),
    )
    z = np.where(clustered, depths[cluster] * np.exp(rng.normal(0, 0.03, count)), rng.uniform(NEAREST, FARTHEST, count))
    focal = FOCAL * WIDTH
    local = np.stack([*((pixels - side / 2) / focal * z[:, None]).T, z], 1)
    camera = bench_camera(WIDTH, HEIGHT)
    R, shift = camera.world_to_camera[:3, :3], camera.world_to_camera[:3, 3]

    radii = median_radius(count) * np.exp(rng.normal(0, RADIUS_SPREAD, count))
    radii[rng.random(count) < LARGE] *= LARGE_FACTOR
    # Flat discs of some length: a longest axis, a shorter one and a thin one.
    axes = np.exp(-np.abs(rng.normal(0, (0, 0.8, 2.0), (count, 3))))
    quats = rng.normal(size=(count, 4))
    scales = axes * (radii / 3 / _seen_length(axes, quats, R) * z / focal)[:, None]

    faint = rng.random(count) < FAINT_SHARE
    opacities = np.where(faint, rng.beta(0.9, 6, count), rng.beta(3, 1.2, count)).clip(0.004, 0.995)
    arrays = (
        (local - shift) @ R,
        np.log(scales),
        quats,
        logits_of(opacities),
        rng.uniform(size=(count, 3)),
    )
    return StaticSplats(*(np.ascontiguousarray(array, dtype=np.float32) for array in arrays))


def _seen_length(
    axes: npt.NDArray[np.float64], quats: npt.NDArray[np.float64], R: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return the standard deviation [N] of the longest axis of splats of these axes [N, 3], seen along z from afar."""
    w, x, y, z = (quats / np.linalg.norm(quats, axis=1, keepdims=True)).T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    turned = np.einsum("ij,jkn->nik", R[:2], np.array(rows)) * axes[:, None, :]
    lengths: npt.NDArray[np.float64] = np.linalg.norm(turned, ord=2, axis=(1, 2))
    return lengths


def _dynamics(rng: np.random.Generator, still: StaticSplats[Floats]) -> DynamicSplats[Floats]:
    """Let splats move by about their depth's hundredth, turn a little, and live for a while."""
    count = len(still)
    motion = np.concatenate([still.means[:, None], rng.normal(0, 0.05, (count, 3, 3))], 1)
    rotation = np.stack([still.quats, rng.normal(0, 0.3, (count, 4))], 1)
    arrays = (
        motion,
        rotation,
        still.log_scales,
        still.opacity_logits,
        rng.uniform(0, 1, count),
        rng.normal(-np.log(2 * LIFE_SPAN * LIFE_SPAN), 0.5, count),
        still.rgb,
    )
    return DynamicSplats(*(np.ascontiguousarray(array, dtype=np.float32) for array in arrays))


def _along_curve(means: Floats) -> npt.NDArray[np.intp]:
    low, high = means.min(0, initial=np.inf), means.max(0, initial=-np.inf)
    cells = (means - low) / np.maximum(high - low, 1e-12) * 1023
    return morton.order(morton.interleave(cells.astype(np.uint32)))
