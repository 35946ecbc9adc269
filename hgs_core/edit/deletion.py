"""Deletions: edits that leave out splats and change no other."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from hgs_core.base.arrays import Mask
from hgs_core.edit.viewed_scene import ViewedScene

__all__ = ["Deletion", "deletion_of"]


@dataclass(frozen=True)
class Deletion:
    """The splats that are left: static ones [N], and those of each segment [M]."""

    static: Mask
    moving: tuple[Mask, ...]


def deletion_of(before: ViewedScene, after: ViewedScene) -> Deletion | None:
    """Return the deletion that leads from one scene to the other, or None if more has changed than that."""
    first, then = before.scene, after.scene
    clocks = [[(one.start, one.end) for one in scene.segments] for scene in (first, then)]
    if clocks[0] != clocks[1] or before.begins != after.begins or not np.array_equal(before.times, after.times):
        return None
    static = _kept(first.static, then.static)
    pairs = zip(first.segments, then.segments, strict=True)
    moving = [_kept(earlier.dynamic, later.dynamic) for earlier, later in pairs]
    if static is None or any(mask is None for mask in moving):
        return None
    return Deletion(static, tuple(mask for mask in moving if mask is not None))


def _kept(before: Any, after: Any) -> Mask | None:
    """Return which splats of a set are left in another, in the same order and to the bit; None if it has others."""
    rows, kept = _rows(before), np.zeros(len(before), np.bool_)
    waiting = iter(range(len(rows)))
    for row in _rows(after):
        place = next((i for i in waiting if rows[i] == row), None)
        if place is None:
            return None
        kept[place] = True
    return kept


def _rows(splats: Any) -> list[bytes]:
    """Return the bytes of each splat."""
    count = len(splats)
    arrays = [getattr(splats, field.name).reshape(count, -1) for field in dataclasses.fields(splats) if count]
    if not arrays:
        return []
    table = np.ascontiguousarray(np.concatenate(arrays, axis=1))
    return [bytes(row) for row in table.view((np.void, table.itemsize * table.shape[1]))[:, 0]]
