"""A page of a manifest: whole segments of it, column by column (docs/format.md, "Index and pages")."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.codec.format.audio import AudioPiece
from hgs_core.codec.format.manifest import ChunkEntry, SegmentEntry, SliceEntry

__all__ = ["MAGIC", "Columns", "Page", "read_columns", "read_page"]

MAGIC = b"HGSP"
_HEADER = 24  # bytes: the magic, and five numbers
_ID = 32  # bytes


@dataclass(frozen=True)
class Columns:
    """A page as it is stored: its rows, column by column."""

    segments: Sequence[tuple[float, float]]  # start and end, seconds
    slices: Sequence[tuple[float, float]]
    pieces: Sequence[tuple[float, float]]
    boxes: Sequence[Sequence[float]]  # chunks' boxes: two corners, one after the other
    segment_slices: Sequence[int]  # how many slices each segment has
    slice_chunks: Sequence[int]  # how many chunks each slice has
    slice_needs: Sequence[int]
    needs: Sequence[int]  # places of chunks in the page
    chunk_bytes: Sequence[int]
    chunk_splats: Sequence[int]
    piece_bytes: Sequence[int]
    ids: Sequence[bytes]  # ids of chunks, then of pieces


@dataclass(frozen=True)
class Page:
    """A stretch of the manifest: whole segments."""

    segments: tuple[SegmentEntry, ...]
    slices: tuple[SliceEntry, ...]  # `segment` counts from the page's first
    pieces: tuple[AudioPiece, ...]  # pieces of sound that begin in this time


def read_columns(data: bytes, where: object = "page") -> Columns:
    """Read a page.

    Raises:
        InputError: it is damaged, or none.
    """
    try:
        raw = gzip.decompress(data)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(where, f"is not gzip ({error})") from error
    counts = np.frombuffer(raw, "<u4", 5, 4).tolist() if len(raw) >= _HEADER else []
    if raw[:4] != MAGIC or not counts:
        raise InputError(where, "is no page of a manifest")
    segments, slices, chunks, needs, pieces = counts
    wholes = (segments, slices, slices, needs, chunks, chunks, pieces)
    length = 16 * (segments + slices + pieces) + 24 * chunks + 4 * sum(wholes) + _ID * (chunks + pieces)
    if len(raw) < _HEADER + length:
        raise InputError(where, f"has {len(raw)} bytes, expected {_HEADER + length}")
    at = _HEADER

    def column(kind: str, count: int) -> Any:
        nonlocal at
        found = np.frombuffer(raw, kind, count, at)
        at += found.nbytes
        return found

    spans = [
        list(zip(column("<f8", count).tolist(), column("<f8", count).tolist(), strict=True))
        for count in (segments, slices, pieces)
    ]
    boxes = column("<f4", 6 * chunks).reshape(-1, 6).tolist()
    counted, own, needed, needs_of, sizes, splats, lengths = (column("<u4", count).tolist() for count in wholes)
    ids = [raw[at + _ID * place : at + _ID * (place + 1)] for place in range(chunks + pieces)]
    columns = Columns(spans[0], spans[1], spans[2], boxes, counted, own, needed, needs_of, sizes, splats, lengths, ids)
    _check(columns, where)
    return columns


def read_page(data: bytes, where: object = "page") -> Page:
    """Read a page as a part of a manifest.

    Raises:
        InputError: as `read_columns`.
    """
    columns = read_columns(data, where)
    names = [name.hex() for name in columns.ids]
    chunks = [
        ChunkEntry(name, size, splats, (_corner(box[:3]), _corner(box[3:])))
        for name, size, splats, box in zip(
            names, columns.chunk_bytes, columns.chunk_splats, columns.boxes, strict=False
        )
    ]
    slices = []
    place = chunk = need = 0
    for segment, count in enumerate(columns.segment_slices):
        for (start, end), own, needed in zip(
            columns.slices[place : place + count],
            columns.slice_chunks[place : place + count],
            columns.slice_needs[place : place + count],
            strict=True,
        ):
            needs = tuple(names[k] for k in columns.needs[need : need + needed])
            slices.append(SliceEntry(segment, start, end, tuple(chunks[chunk : chunk + own]), needs))
            chunk, need = chunk + own, need + needed
        place += count
    pieces = zip(names[len(chunks) :], columns.piece_bytes, columns.pieces, strict=True)
    return Page(
        tuple(SegmentEntry(*span) for span in columns.segments),
        tuple(slices),
        tuple(AudioPiece(name, size, *span) for name, size, span in pieces),
    )


def _check(columns: Columns, where: object) -> None:
    own, needed = sum(columns.slice_chunks), sum(columns.slice_needs)
    counts = (
        ("slices", sum(columns.segment_slices), len(columns.slices)),
        ("chunks", own, len(columns.boxes)),
        ("needs", needed, len(columns.needs)),
    )
    for name, found, expected in counts:
        if found != expected:
            raise InputError(where, f"names {found} {name}, expected {expected}")
    if max(columns.needs, default=-1) >= own:
        raise InputError(where, f"needs the chunk {max(columns.needs)} of {own}")


def _corner(numbers: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = numbers
    return x, y, z
