"""Merging two scenes into one that shows both."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterable

import numpy as np

from hgs_core.base.arrays import Doubles, Floats
from hgs_core.base.errors import InputError
from hgs_core.edit.shared_statics import SharedStatics, shared_statics
from hgs_core.edit.trim import SHORTEST_SHARE, cut, seen_until
from hgs_core.edit.viewed_scene import Edit, ViewedScene, shown_until
from hgs_core.interchange.changes import Action, Change, nonzero
from hgs_core.scene.at_rest import at_rest
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, HybridScene, Segment, joined

__all__ = ["merge"]


def merge(first: ViewedScene, second: ViewedScene, at: float | None = None) -> Edit:
    """Return both scenes in one, on the clock of the first; the second begins at second `at` of it, or with it.

    The second must lie in the same world (`orient` brings it there). Each scene's moving splats are there while it
    lasts, its static splats always, unless both are takes of one set (`shared_statics.py`): what both show of it is
    that of the second while it lasts and the first does not, else that of the first. Where segments of both overlap in
    part they are cut at each other's borders, so that splats that live across a cut are stored on both sides of it.

    Raises:
        InputError: the scenes are drawn differently, `at` is before the first begins or leaves too short a segment, or
            both show one set, and one of them lasts no time.
    """
    a, b = first.scene, second.scene
    if a.antialiased != b.antialiased:
        words = ["drawn antialiased" if scene.antialiased else "not drawn antialiased" for scene in (a, b)]
        raise InputError(
            "--merge",
            f"was trained to be {words[1]}, and the scene to be {words[0]}: one of the two would look wrong",
            "train one of them again with train.antialiased as the other has it",
        )
    if not np.allclose(a.background, b.background, atol=1 / 512):
        shown = [",".join(f"{value:g}" for value in scene.background) for scene in (a, b)]
        raise InputError(
            "--merge",
            f"has the background {shown[1]}, and the scene {shown[0]}: a scene has one",
            "train one of them again before the other's background",
        )
    if at is not None and not at >= a.start:
        raise InputError("--at", f"{at:g} s is before the scene begins", f"give {a.start:g} or more")
    second = _shifted(second, (a.start if at is None else at) - b.start)
    statics = shared_statics(a.static, b.static)
    if statics.by_time and not (a.end > a.start and b.end > b.start):
        raise InputError(
            "--merge",
            f"{len(statics.first):,} static splats of the scene and {len(statics.second):,} of the other fill the same "
            "places, and a still scene is always shown: everything there would stand twice",
            "cut out of one of them what the other has: hgs edit with --box or --sphere, and --inverse",
        )
    parts = _segments(a, second.scene)
    stored = 0
    if statics.by_time:
        parts = tuple(_with_statics(part, a, second.scene, statics) for part in parts)
        stored = sum(len(s.dynamic) for s in parts) - sum(len(s.dynamic) for s in _segments(a, second.scene))
    cameras, renamed = _cameras(first.cameras, second.cameras)
    merged = HybridScene(statics.always, parts, a.background, a.antialiased)
    total = len(a.static) + len(b.static) + a.dynamic_splats + b.dynamic_splats
    instants = sum(len(s.dynamic) for s in (*a.segments, *second.scene.segments) if s.end == s.start)
    instants = instants if merged.end > merged.start else 0
    copies = merged.dynamic_splats - stored + instants - a.dynamic_splats - b.dynamic_splats
    by_time = f"both scenes show them: the second's while it alone lasts, else the first's; {stored:,} copies"
    changes = (
        Change(Action.LEFT_OUT, "splats", statics.twice, total, "both scenes have them"),
        Change(Action.REPLACED, "static splats", statics.by_time, total, f"by some that live for a time: {by_time}"),
        Change(Action.LEFT_OUT, "splats", instants, total, "their segment lasts no time"),
        Change(
            Action.REPLACED,
            "segments",
            max(copies, 0),
            total,
            "they live across a border of the other's segments, and are stored on both sides of it",
        ),
        *(
            [Change.whole(Action.REPLACED, "camera names", f"{renamed} of the second have names of the first")]
            if renamed
            else []
        ),
    )
    times = _clock(first.times, second.times, merged)
    return Edit(ViewedScene(merged, cameras, times, first.up, first.begins), nonzero(changes))


def _with_statics(
    part: Segment[Floats], a: HybridScene[Floats], b: HybridScene[Floats], statics: SharedStatics
) -> Segment[Floats]:
    """Add to a segment of a merged scene the static splats that are shown for its time alone."""
    of_second = b.start <= part.start < b.end and not a.start <= part.start < a.end
    shown = statics.second if of_second else statics.first
    return dataclasses.replace(part, dynamic=joined([part.dynamic, at_rest(shown)]))


def _shifted(viewed: ViewedScene, by: float) -> ViewedScene:
    segments = tuple(dataclasses.replace(s, start=s.start + by, end=s.end + by) for s in viewed.scene.segments)
    return dataclasses.replace(
        viewed, scene=dataclasses.replace(viewed.scene, segments=segments), times=viewed.times + by
    )


def _segments(a: HybridScene[Floats], b: HybridScene[Floats]) -> tuple[Segment[Floats], ...]:
    """Return the segments of both: cut wherever one of them begins or the scene that it belongs to ends."""
    moving = [scene for scene in (a, b) if scene.end > scene.start]
    if not moving:  # pictures without time
        return (Segment(a.start, a.start, joined([s.dynamic for scene in (a, b) for s in scene.segments])),)
    still = [s.dynamic for scene in (a, b) if scene.end == scene.start for s in scene.segments]
    if any(len(dynamic) for dynamic in still):
        raise InputError(
            "--merge", "one of the scenes has moving splats and lasts no time", "export it as a still scene"
        )
    if len(moving) == 1:
        return moving[0].segments
    borders = sorted({s.start for scene in moving for s in scene.segments} | {scene.end for scene in moving})
    parts = []
    for start, until in itertools.pairwise(borders):
        sets = [found for scene in moving for found in _cut_out(scene, start, until)]
        parts.append(Segment(start, until, joined(sets) if sets else DynamicSplats.empty()))
    return tuple(parts)


def _cut_out(scene: HybridScene[Floats], start: float, until: float) -> Iterable[DynamicSplats[Floats]]:
    """Yield the splats of a scene between two borders, in their normalised time."""
    if start >= scene.end or until <= scene.start:
        return
    segment = scene.segment_at(start)
    number = next(i for i, other in enumerate(scene.segments) if other is segment)
    if until - start < SHORTEST_SHARE * (segment.end - segment.start):
        cure = "move --at by a frame"
        raise InputError("--merge", f"leaves a segment of only {until - start:g} s at {start:g} s", cure)
    assert until <= max(shown_until(scene, number), scene.end)
    yield seen_until(cut(segment, start, until), 1.0)


def _clock(a: Doubles, b: Doubles, scene: HybridScene[Floats]) -> Doubles:
    """Return frames all over the merged scene, as often as the first one's, or as the second's if that is a still."""
    steps = [float(np.median(np.diff(times))) for times in (a, b) if len(times) > 1]
    if not steps:
        return a
    count = int(np.floor((scene.end - scene.start) / steps[0] + 1e-6)) + 1
    return np.asarray(scene.start + steps[0] * np.arange(count), np.float64)


def _cameras(a: tuple[Camera, ...], b: tuple[Camera, ...]) -> tuple[tuple[Camera, ...], int]:
    """Return the cameras of both; those of the second get another name where the first has one of that name."""
    names = {camera.name for camera in a}
    found, renamed = list(a), 0
    for camera in b:
        name, number = camera.name, 2
        while name in names:
            name, number = f"{camera.name}-{number}", number + 1
        renamed += name != camera.name
        names.add(name)
        found.append(dataclasses.replace(camera, name=name))
    return tuple(found), renamed
