"""Trimming: a stretch of a scene as a scene of its own, with a clock from 0."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.edit.viewed_scene import Edit, ViewedScene, shown_until
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment
from hgs_core.scene.temporal import lifetime

__all__ = ["cut", "seen_until", "trim"]

LARGEST_LOG_PRECISION = 80.0  # upper limit (docs/numerics.md)
SHORTEST_SHARE = 1e-4  # share of a segment; a shorter part exceeds the precision of float32
SLACK = 1e-6  # seconds by which a frame may miss the ends


def trim(viewed: ViewedScene, start: float, end: float) -> Edit:
    """Keep the splats visible from `start` to `end`, seconds of the scene's clock; `start` becomes 0.

    Paths, turns and lives are the same functions of time as before: their polynomials are written about the same
    centres in the new segments' time. Splats that live at no moment of it are left out.

    Raises:
        InputError: the stretch is not one of the scene, or of a segment there is too little in it.
    """
    scene = viewed.scene
    asked = f"{start:g} to {end:g} s"
    if not scene.start <= start < end <= scene.end + SLACK:
        if scene.end == scene.start:
            raise InputError("--trim", f"{asked} of a scene that lasts no time", "leave it out")
        raise InputError(
            "--trim", f"{asked} is no stretch of the scene", f"give two seconds of {scene.start:g} to {scene.end:g}"
        )
    end = min(end, scene.end)
    parts: list[Segment[Floats]] = []
    for number, segment in enumerate(scene.segments):
        if segment.end == segment.start:  # a single frame
            if start <= segment.start <= end:
                parts.append(Segment(segment.start - start, segment.start - start, segment.dynamic))
            continue
        until = shown_until(scene, number)
        first = max(segment.start, start)
        last = min(segment.end if first < segment.end else until, end)
        if first >= min(until, end):
            continue
        if last - first < SHORTEST_SHARE * (segment.end - segment.start):
            cure = "move that end by a frame"
            raise InputError("--trim", f"{asked} holds only {last - first:g} s of segment {number}", cure)
        dynamic = cut(segment, first, last)
        shown = seen_until(dynamic, (min(until, end) - first) / (last - first))
        parts.append(Segment(first - start, last - start, shown))
    times = viewed.times[(viewed.times >= start - SLACK) & (viewed.times <= end + SLACK)] - start
    kept = dataclasses.replace(scene, segments=tuple(parts))
    return Edit(
        dataclasses.replace(
            viewed,
            scene=kept,
            times=np.maximum(times, 0.0) if len(times) else np.zeros(1),
            begins=viewed.begins + start,
        ),
        nonzero((_unseen(scene, kept, asked),)),
    )


def cut(segment: Segment[Floats], start: float, end: float) -> DynamicSplats[Floats]:
    """Return a segment's splats in the normalised time of a stretch from `start` to `end`, seconds, with end > start.

    With t = offset + factor t' it is d = factor d', so that the k-th coefficient of a path is multiplied by factor^k.
    """
    length = segment.end - segment.start
    offset, factor = (start - segment.start) / length, (end - start) / length
    dynamic = segment.dynamic
    motion = dynamic.motion * factor ** np.arange(dynamic.motion.shape[1], dtype=np.float64)[:, None]
    rotation = dynamic.rotation * np.array([1.0, factor])[:, None]
    center = (dynamic.time_centers.astype(np.float64) - offset) / factor
    precision = np.minimum(dynamic.time_log_precisions.astype(np.float64), LARGEST_LOG_PRECISION) + 2 * math.log(factor)
    return dataclasses.replace(
        dynamic,
        motion=motion.astype(np.float32),
        rotation=rotation.astype(np.float32),
        time_centers=center.astype(np.float32),
        time_log_precisions=precision.astype(np.float32),
    )


def seen_until(dynamic: DynamicSplats[Floats], until: float) -> DynamicSplats[Floats]:
    """Return the splats that live at some normalised time from 0 to `until`; leaving out the others is exact."""
    first, last = lifetime(dynamic)
    return dynamic.take((first <= until) & (last >= 0))


def _unseen(before: HybridScene[Floats], after: HybridScene[Floats], asked: str) -> Change:
    total = len(before.static) + before.dynamic_splats
    gone = before.dynamic_splats - after.dynamic_splats
    return Change(Action.LEFT_OUT, "splats", gone, total, f"they do not live from {asked}")
