"""Floaters: splats that stand alone, far from everything else."""

from __future__ import annotations

import dataclasses

import numpy as np

from hgs_core.base.arrays import Doubles, Floats, Mask
from hgs_core.edit.viewed_scene import Edit, ViewedScene, shown_until
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.points.neighbours import mean_neighbour_distance
from hgs_core.scene.splats import DynamicSplats
from hgs_core.scene.temporal import evaluate, lifetime

__all__ = ["drop_floaters", "floating"]

NEIGHBOURS = 8
FARTHER = 8.0  # times the median distance to neighbours
OWN_SIZES = 4.0  # standard deviations along the longest axis


def drop_floaters(viewed: ViewedScene) -> Edit:
    """Leave out floaters (see `floating`); moving splats are judged in the middle of their visible lives.

    A moving splat's neighbours are the static ones and those of its own segment; a static one's are the static ones and
    the moving ones of all segments, so that nothing that any of them touches goes.
    """
    scene = viewed.scene
    moving = [_places(part.dynamic, part.normalised(shown_until(scene, i))) for i, part in enumerate(scene.segments)]
    still = scene.static.means.astype(np.float64), _sizes(scene.static.log_scales)
    everything = [np.concatenate(parts) for parts in zip(still, *moving, strict=True)]
    lone = floating(*everything)[: len(scene.static)]
    segments, gone = [], int(lone.sum())
    for segment, (places, sizes) in zip(scene.segments, moving, strict=True):
        alone = floating(np.concatenate([places, still[0]]), np.concatenate([sizes, still[1]]))[: len(places)]
        segments.append(dataclasses.replace(segment, dynamic=segment.dynamic.take(~alone)))
        gone += int(alone.sum())
    kept = dataclasses.replace(scene, static=scene.static.take(~lone), segments=tuple(segments))
    total = len(scene.static) + scene.dynamic_splats
    reason = f"they stand alone: {FARTHER:g} times as far from others as most, and {OWN_SIZES:g} times their own size"
    return Edit(
        dataclasses.replace(viewed, scene=kept), nonzero((Change(Action.LEFT_OUT, "splats", gone, total, reason),))
    )


def floating(places: Doubles, sizes: Doubles) -> Mask:
    """Return which splats at `places` [N, 3] with longest standard deviations `sizes` [N] float.

    The mean distance to the 8 nearest others is more than 8 times that of the median splat, and more than 4 times
    the splat's own size: a sky of few splats that are as large as the gaps between them stays. Nothing floats among
    so few splats that neighbours say nothing.
    """
    away = mean_neighbour_distance(places, NEIGHBOURS).astype(np.float64)
    if not len(away):
        return np.zeros(0, np.bool_)
    return np.asarray((away > FARTHER * np.median(away)) & (away > OWN_SIZES * sizes))


def _places(dynamic: DynamicSplats[Floats], until: float) -> tuple[Doubles, Doubles]:
    first, last = lifetime(dynamic)
    middle = (np.clip(first, 0.0, until) + np.clip(last, 0.0, until)) / 2
    return evaluate(dynamic, middle)[0], _sizes(dynamic.log_scales)


def _sizes(log_scales: Floats) -> Doubles:
    return np.asarray(np.exp(log_scales.astype(np.float64).max(axis=1, initial=-np.inf)))
