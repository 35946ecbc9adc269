"""Cameras for a scene that came without any, where its detail asks for them: as near as splats are fine, and before it.

Training leaves splats of about two pixels where pictures were taken, so that the size of splats tells how far away
cameras stood. They stood where much is seen: not behind a wall, nor in the midst of things. In a room that is inside.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.scene.camera import Camera

__all__ = ["DIRECTIONS", "best_directions", "detail_distances"]

PIXELS = 2.0  # standard deviation of splats, in the middle of what a camera looks at
NEIGHBOURS = 256  # splats around a place that tell how fine detail is there
NEAREST, FARTHEST = 0.02, 1.0  # shares of the distance that shows the whole
DIRECTIONS = 16  # directions tried for each place
SPREAD_PENALTY = 0.7  # factor on a direction's splats for each earlier choice


def detail_distances(targets: Doubles, places: Doubles, log_scales: Floats, focal: float, whole: float) -> Doubles:
    """Return from how far [T] to look at places [T, 3], so that splats there are as large as training leaves them.

    Args:
        targets: places to look at.
        places: [P, 3] of all splats.
        log_scales: [P, 3] of them.
        focal: pixels.
        whole: distance from which the whole scene is seen.
    """
    axes = np.sort(log_scales.astype(np.float64), axis=1)
    size = np.exp(axes[:, 1:].mean(axis=1))  # size along the thinnest axis' view
    found = []
    for target in targets:
        away = ((places - target) ** 2).sum(axis=1)
        around = np.argpartition(away, min(NEIGHBOURS, len(away) - 1))[:NEIGHBOURS]
        found.append(float(np.median(size[around])) * focal / PIXELS)
    return np.clip(found, NEAREST * whole, FARTHEST * whole)


def best_directions(
    targets: Doubles,
    distances: Doubles,
    directions: Doubles,
    camera: Callable[[Doubles, Doubles], Camera],
    seen: Callable[[Camera], int],
) -> Doubles:
    """Return the direction [T, 3] from which each target shows most splats; one that was chosen often counts less.

    Args:
        targets: [T, 3] places to look at.
        distances: [T] from how far.
        directions: [D, 3] unit vectors to choose from.
        camera: makes one that looks at a place from a vector away.
        seen: how many splats a camera sees.
    """
    chosen, found = np.zeros(len(directions)), []
    for target, distance in zip(targets, distances, strict=True):
        counts = np.array([seen(camera(target, distance * direction)) for direction in directions], np.float64)
        best = int((counts * SPREAD_PENALTY ** (chosen / 2)).argmax())
        chosen[best] += 1
        found.append(directions[best])
    return np.array(found)
