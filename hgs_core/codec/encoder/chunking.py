"""How splats are cut into chunks: by how much they show, dynamics also by when they live."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.arrays import Doubles
from hgs_core.codec.encoder.encode_dynamic import SegmentTime
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.prepare import PreparedDynamics, PreparedStatics
from hgs_core.codec.encoder.steps import FINEST_SHARE, ideal_position_steps
from hgs_core.codec.encoder.utility import grades

__all__ = ["Layer", "dynamic_layers", "slice_limits", "static_layers"]

# A splat whose position step would be wider than the others' by this factor goes to another chunk.
LARGEST_STEP_RATIO = 8.0
LONG_LIVED_SPLATS = 2048  # splats that live on together, from which they get chunks apart from those that die earlier

Index = NDArray[np.intp]


@dataclass(frozen=True)
class Layer:
    """The splats of one chunk."""

    index: Index
    utility: float  # mean of the splats': the higher, the earlier it is worth fetching
    slice: int = 0  # first slice of dynamic splats' lives


def static_layers(splats: PreparedStatics, settings: EncodeSettings) -> list[Layer]:
    """Cut static splats into chunks of like grade, those that show most first."""
    everyone = np.arange(len(splats))
    layers = [
        Layer(part, float(splats.utility[part].mean()))
        for part in _like(everyone, splats, settings, settings.static_chunk_splats)
    ]
    return sorted(layers, key=lambda layer: -layer.utility)


def slice_limits(time: SegmentTime, until: float, settings: EncodeSettings) -> tuple[Doubles, Doubles]:
    """Return the ascending limits [S + 1] of equal slices of a segment, shown until `until`: seconds, normalised."""
    count = max(1, round((until - time.start) / settings.slice_seconds))
    return np.linspace(time.start, until, count + 1), np.linspace(0.0, time.shown_until, count + 1)


def dynamic_layers(
    splats: PreparedDynamics, time: SegmentTime, limits: Doubles, settings: EncodeSettings
) -> list[Layer]:
    """Cut the splats of a segment into chunks by the first slice in which they live, by the last, and by grade.

    `limits` [S + 1] are the slices' limits in normalised time. Chunks of splats that die together let a seek leave out
    what is already dead; a chunk is not made smaller than `LONG_LIVED_SPLATS` for that. Within a slice those that show
    most come first.
    """
    if len(splats) == 0:
        return []
    start, end = time.life(splats, settings)
    last_slice = len(limits) - 2
    first = np.clip(np.searchsorted(limits, start, side="right") - 1, 0, last_slice)
    last = np.clip(np.searchsorted(limits, end, side="right") - 1, 0, last_slice)
    layers: list[Layer] = []
    for current in range(last_slice + 1):
        parts = [
            part
            for group in _by_last(np.flatnonzero(first == current), last)
            for part in _like(group, splats, settings, settings.dynamic_chunk_splats)
        ]
        found = [Layer(part, float(splats.utility[part].mean()), current) for part in parts]
        layers += sorted(found, key=lambda layer: -layer.utility)
    return layers


def _by_last(members: Index, last: NDArray[np.intp]) -> list[Index]:
    """Group splats by the last slice they live in; groups smaller than `LONG_LIVED_SPLATS` are joined with the next."""
    return _without_small([members[last[members] == final] for final in np.unique(last[members])], LONG_LIVED_SPLATS)


def _without_small(parts: Iterable[Index], least: int) -> list[Index]:
    """Join parts with the next ones until they have `least` splats, a small rest with the last group."""
    groups: list[Index] = []
    waiting = np.zeros(0, np.intp)
    for part in parts:
        waiting = np.concatenate([waiting, part])
        if len(waiting) >= least:
            groups.append(waiting)
            waiting = waiting[:0]
    if len(waiting) and groups:
        groups[-1] = np.concatenate([groups[-1], waiting])
    elif len(waiting):
        groups.append(waiting)
    return groups


def _like(members: Index, splats: PreparedStatics, settings: EncodeSettings, largest: int) -> list[Index]:
    """Cut splats into chunks of about one grade and, within it, of position steps of about one size.

    Grades of fewer than `small_chunk_splats` are joined with the next lower one: the finest of a chunk counts.
    """
    grade = grades(splats.utility[members, 0])
    groups = _without_small((members[grade == value] for value in np.unique(grade)[::-1]), settings.small_chunk_splats)
    parts: list[Index] = []
    for group in groups:
        step = ideal_position_steps(splats.take(group), settings)
        level = np.maximum(np.floor(np.log(step / np.median(step)) / np.log(LARGEST_STEP_RATIO)), 0)
        near = np.abs(splats.position[group]).max(axis=1) * FINEST_SHARE < np.median(step)
        if (level > 0).sum() < settings.small_chunk_splats:
            level[near] = 0  # float32 can hold them on the others' grid, and so few do not pay for a chunk
        for one in np.unique(level):
            same = group[level == one]
            useful = np.argsort(-splats.utility[same, 0], kind="stable")
            parts += _even_parts(same[useful], largest)
    return parts


def _even_parts(members: Index, largest: int) -> list[Index]:
    return [np.asarray(part) for part in np.array_split(members, -(-len(members) // largest))] if len(members) else []
