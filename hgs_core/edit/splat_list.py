"""Splats listed by hand: a file of chunks and places in them, and the scene without these splats."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hgs_core.base.arrays import Mask
from hgs_core.base.errors import InputError
from hgs_core.edit.edit_file import EditFormat, read_edit_file, shown
from hgs_core.edit.viewed_scene import Edit, ViewedScene
from hgs_core.interchange.changes import Action, Change, nonzero

__all__ = ["ChunkSizes", "SplatList", "drop_listed"]

_CHUNK = re.compile(r"[0-9a-f]{64}")
_AGAIN = "save the list again on the scene's page"

ChunkSizes = Sequence[tuple[str, int]]
"""Ids of chunks with their numbers of splats, in the order in which a decoded scene has them."""


@dataclass(frozen=True)
class SplatList:
    """Listed splats by the id of their chunk: ranges, of which both ends count, ascending."""

    file: Path
    chunks: Mapping[str, Sequence[tuple[int, int]]]

    @classmethod
    def load(cls, file: Path) -> SplatList:
        """Read a list (docs/editing.md).

        Raises:
            InputError: it is missing, too large or no list of splats; names the file, the field and the value.
        """
        return cls.of(file, read_edit_file(file, (EditFormat.SPLATS,)))

    @classmethod
    def of(cls, file: Path, fields: dict[str, Any]) -> SplatList:
        """Read the fields of a file with a checked format.

        Raises:
            InputError: the chunks are malformed.
        """
        chunks = fields.get("chunks")
        if not isinstance(chunks, dict) or not chunks:
            raise InputError(f"{file}: chunks", f"is {shown(chunks)}, not an object of chunks", _AGAIN)
        for chunk in chunks:
            if not _CHUNK.fullmatch(chunk):
                raise InputError(f"{file}: chunks", f"{chunk[:80]!a} is not the id of a chunk", _AGAIN)
        return cls(file, {chunk: _ranges(f"{file}: chunks.{chunk}", value) for chunk, value in chunks.items()})


def drop_listed(viewed: ViewedScene, listed: SplatList, static: ChunkSizes, segments: Sequence[ChunkSizes]) -> Edit:
    """Leave out the listed splats of a decoded scene, of which these are the chunks.

    Raises:
        InputError: a chunk or a splat of the list is not in the scene.
    """
    sizes = dict(pair for chunks in (static, *segments) for pair in chunks)
    for chunk, ranges in listed.chunks.items():
        where = f"{listed.file}: chunks.{chunk}"
        if chunk not in sizes:
            raise InputError(where, "is not a chunk of this scene", "give the scene in which the list was made")
        if ranges[-1][1] >= sizes[chunk]:
            raise InputError(where, f"names splat {ranges[-1][1]} of {sizes[chunk]}, which count from 0", _AGAIN)
    scene = viewed.scene
    kept = dataclasses.replace(
        scene,
        static=scene.static.take(_unlisted(listed, static)),
        segments=tuple(
            dataclasses.replace(segment, dynamic=segment.dynamic.take(_unlisted(listed, chunks)))
            for segment, chunks in zip(scene.segments, segments, strict=True)
        ),
    )
    total = len(scene.static) + scene.dynamic_splats
    gone = total - len(kept.static) - kept.dynamic_splats
    change = Change(Action.LEFT_OUT, "splats", gone, total, f"{listed.file.name} lists them")
    return Edit(dataclasses.replace(viewed, scene=kept), nonzero((change,)))


def _unlisted(listed: SplatList, chunks: ChunkSizes) -> Mask:
    keep = np.ones(sum(count for _, count in chunks), np.bool_)
    start = 0
    for chunk, count in chunks:
        for first, last in listed.chunks.get(chunk, ()):
            keep[start + first : start + last + 1] = False
        start += count
    return keep


def _ranges(where: str, value: Any) -> list[tuple[int, int]]:
    if not isinstance(value, list) or not value:
        raise InputError(where, f"is {shown(value)}, not a list of ranges", _AGAIN)
    before, ranges = -1, list[tuple[int, int]]()
    for i, one in enumerate(value):
        pair = one if isinstance(one, list) and len(one) == 2 and all(type(end) is int for end in one) else None
        if pair is None:
            raise InputError(f"{where}[{i}]", f"is {shown(one)}, not two whole numbers", "give [first, last]")
        first, last = pair
        if not before < first <= last:
            raise InputError(f"{where}[{i}]", f"{shown(one)} does not ascend from {before}", "sort and join the ranges")
        before = last
        ranges.append((first, last))
    return ranges
