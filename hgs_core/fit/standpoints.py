"""Places inside of a scene where a person could stand: nothing is near there, and something is seen all around.

Rooms have such places, and hollow things.
"""

from __future__ import annotations

import numpy as np
import torch

from hgs_core.base.arrays import Doubles, Floats, Whole
from hgs_core.render.rasterize import rasterize
from hgs_core.render.threads import one_torch_thread
from hgs_core.scene.camera import Camera
from hgs_core.scene.rotations import matrices
from hgs_core.scene.splats import HybridScene

__all__ = ["standpoints"]

CANDIDATES = 256  # places, evenly spread over the box in which most of all opacity lies
INNER = (0.05, 0.95)  # quantiles of opacity along each axis: the box
TRIED = 24  # candidates that have most room around them, of which pictures are drawn
SURROUNDED = 0.6  # share of directions with something in sight
ROOM = 0.05  # share of the box's diagonal kept free of all but a few splats
FEW = 0.002  # share of all opacity
FACES = np.array([[1, 0, 0, 0], [1, 0, 1, 0], [0, 0, 1, 0], [1, 0, -1, 0], [1, 1, 0, 0], [1, -1, 0, 0]], np.float64)
"""Quaternions of the six sides of a cube, w first; not of length 1."""

SIZE = 32  # pixels of a side
_BASES = (2, 3, 5)


def standpoints(scene: HybridScene[Floats], places: Doubles, sizes: Doubles, weights: Doubles) -> Doubles:
    """Return places [K, 3] inside of a scene where a person could stand, those with most room first; maybe none.

    Args:
        scene: what is looked at, in the middle of its time.
        places: [P, 3] of its splats.
        sizes: [P], how far they reach.
        weights: [P], their opacities.
    """
    order = np.argsort(places, axis=0)
    total = np.cumsum(weights[order], axis=0)
    ordered = np.take_along_axis(places, order, axis=0)
    low, high = (
        np.array([ordered[np.searchsorted(total[:, i], share * total[-1, i]), i] for i in range(3)]) for share in INNER
    )
    candidates = low + (high - low) * _halton(CANDIDATES)
    clear = np.array([_room(places, sizes, weights, one) for one in candidates])
    roomy = np.argsort(-clear, kind="stable")[:TRIED]
    roomy = roomy[clear[roomy] >= max(ROOM * float(np.linalg.norm(high - low)), 1e-9)]
    return np.array([one for one in candidates[roomy] if _surrounded(scene, one)]).reshape(-1, 3)


def _room(places: Doubles, sizes: Doubles, weights: Doubles, eye: Doubles) -> float:
    """Return how far from a place all splats are, but for a few."""
    away = np.linalg.norm(places - eye, axis=1) - sizes
    order = np.argsort(away, kind="stable")
    total = np.cumsum(weights[order])
    return float(away[order[np.searchsorted(total, FEW * total[-1])]])


def _surrounded(scene: HybridScene[Floats], eye: Doubles) -> bool:
    """Return whether something is seen from a place in most directions."""
    seconds = (scene.start + scene.end) / 2
    segment = scene.segment_at(seconds)
    tensors, dynamic = scene.static.map(torch.from_numpy), segment.dynamic.map(torch.from_numpy)
    covered = []
    with one_torch_thread():
        for turn in FACES:
            pose = np.eye(4)
            pose[:3, :3] = matrices(turn / np.linalg.norm(turn))
            pose[:3, 3] = -pose[:3, :3] @ eye
            camera = Camera("", SIZE, SIZE, SIZE / 2, SIZE / 2, SIZE / 2, SIZE / 2, pose, near=1e-6)
            drawn = rasterize(
                tensors, dynamic, camera, segment.normalised(seconds), gradients="none", antialiased=scene.antialiased
            )
            covered.append(float(drawn.alpha.mean()))
    return float(np.mean(covered)) >= SURROUNDED


def _halton(count: int) -> Doubles:
    """Return `count` places [count, 3] that are evenly spread over the unit cube (Halton, 1960)."""
    numbers: Whole = np.arange(1, count + 1)
    found = np.zeros((count, 3))
    for axis, base in enumerate(_BASES):
        left, share = numbers.copy(), 1.0
        while left.any():
            share /= base
            found[:, axis] += share * (left % base)
            left //= base
    return found
