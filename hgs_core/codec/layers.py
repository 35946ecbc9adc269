"""How splats are cut into chunks: statics by how much they show, dynamics by when they live."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.camera import Camera
from hgs_core.codec.attributes import MOTION_ORDERS
from hgs_core.codec.encode_chunk import SegmentTime
from hgs_core.codec.prepare import Prepared
from hgs_core.codec.settings import EncodeSettings

__all__ = ["Layer", "dynamic_layers", "slice_times", "static_layers"]

FINEST_SHARE = 2.0**-19  # a bound below this share of a coordinate costs more bits than float32 is worth

Index = NDArray[np.intp]
Doubles = NDArray[np.float64]


@dataclass(frozen=True)
class Layer:
    """The splats of one chunk, and the position bound they are encoded with."""

    index: Index
    bound: float
    slice: int = 0  # of dynamic splats: the first slice in which they live


def static_layers(
    splats: Prepared, cameras: Sequence[Camera], near: float, bound: float, settings: EncodeSettings
) -> list[Layer]:
    """Cut static splats into chunks, the most visible first.

    A splat's weight is its opacity times the solid angle it fills, averaged over the cameras. Splats whose nearest
    camera is 4, 16, ... times farther than `near` (the cameras' distance from the scene) may be off by as much more:
    no camera of the capture sees the difference, and a coarser grid costs fewer bits.
    """
    if len(splats) == 0:
        return []
    means = splats.values["position"]
    scales = np.sort(np.exp(splats.values["log_scale"]), axis=1)
    area = scales[:, 1] * scales[:, 2]
    weight = np.zeros(len(splats))
    nearest = np.full(len(splats), np.inf)
    for camera in cameras:
        distance = np.linalg.norm(means - camera.position, axis=1)
        weight += np.minimum(1.0, area / np.maximum(distance, 1e-3 * near) ** 2)
        nearest = np.minimum(nearest, distance)
    weight *= splats.values["opacity"][:, 0]
    coarse = np.floor(np.log2(np.maximum(nearest / near, 1.0)) / 2)
    coarse = np.maximum(coarse, _coarse(np.abs(means).max(axis=1), bound))
    layers: list[tuple[float, Layer]] = []
    for level in np.unique(coarse):
        members = np.flatnonzero(coarse == level)
        members = members[np.argsort(-weight[members], kind="stable")]
        for part in _even_parts(members, settings.static_chunk_splats):
            layers.append((float(weight[part].mean()), Layer(part, bound * 4.0**level)))
    return [layer for _, layer in sorted(layers, key=lambda item: -item[0])]


def slice_times(start: float, end: float, slice_seconds: float) -> Doubles:
    """Return the ascending limits [S + 1] in seconds of the equal slices of [start, end]."""
    count = max(1, round((end - start) / slice_seconds))
    return np.linspace(start, end, count + 1)


def dynamic_layers(
    splats: Prepared, time: SegmentTime, limits: Doubles, bound: float, settings: EncodeSettings
) -> list[Layer]:
    """Cut the splats of a segment into chunks by the first slice in which they live, and within it by the last.

    `limits` [S + 1] are the slices' limits in normalised time. Chunks of splats that die together let a seek leave
    out what is already dead; a chunk is not made smaller than `small_chunk_splats` for that.
    """
    start, end = time.life(splats)
    last_slice = len(limits) - 2
    first = np.clip(np.searchsorted(limits, start, side="right") - 1, 0, last_slice)
    last = np.clip(np.searchsorted(limits, end, side="right") - 1, 0, last_slice)
    center = splats.values["time_center"][:, 0]
    reach = np.maximum(np.abs(start - center), np.abs(end - center))[:, None]
    size = sum(np.abs(splats.values[n]) * reach**k for k, n in enumerate(("position", *MOTION_ORDERS)))
    coarse = _coarse(np.asarray(size).max(axis=1), bound) if len(splats) else np.zeros(0)
    layers: list[Layer] = []
    for current in range(last_slice + 1):
        for level in np.unique(coarse[first == current]):
            members = np.flatnonzero((first == current) & (coarse == level))
            for group in _by_last(members, last, settings.small_chunk_splats):
                for part in _even_parts(group, settings.dynamic_chunk_splats):
                    layers.append(Layer(part, bound * 4.0**level, current))
    return layers


def _by_last(members: Index, last: NDArray[np.intp], smallest: int) -> list[Index]:
    """Group splats by the last slice they live in; groups smaller than `smallest` are joined with the next."""
    groups: list[Index] = []
    waiting = np.zeros(0, np.intp)
    for final in np.unique(last[members]):
        waiting = np.concatenate([waiting, members[last[members] == final]])
        if len(waiting) >= smallest:
            groups.append(waiting)
            waiting = waiting[:0]
    if len(waiting) and groups:
        groups[-1] = np.concatenate([groups[-1], waiting])
    elif len(waiting):
        groups.append(waiting)
    return groups


def _coarse(size: Doubles, bound: float) -> Doubles:
    """Return how many factors of 4 the bound must grow by to be worth storing for numbers of this size."""
    return np.ceil(np.log2(np.maximum(size * FINEST_SHARE / bound, 1.0)) / 2)


def _even_parts(members: Index, largest: int) -> list[Index]:
    return [np.asarray(part) for part in np.array_split(members, -(-len(members) // largest))] if len(members) else []
