"""Putting the manifest of a long scene into pages, with an index (docs/format.md, "Index and pages")."""

from __future__ import annotations

import gzip
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hgs_core.codec.format.audio import AudioPiece
from hgs_core.codec.format.chunk import Box
from hgs_core.codec.format.manifest import Manifest, SegmentEntry, SliceEntry
from hgs_core.codec.format.pages import MAGIC

__all__ = ["INDEX", "INDEX_FORMAT", "INDEX_VERSION", "WHOLE", "PagedScene", "paged"]

INDEX = "index.hgs"
INDEX_FORMAT = "hgs-index"
INDEX_VERSION = 1
WHOLE = 256  # chunks of slices, up to which a scene has no pages, unless it grows
PAGE = 128  # chunks with which a page is full

_LEVEL = 6  # gzip level: ids do not compress


@dataclass(frozen=True)
class PagedScene:
    """The published forms of a scene beside its manifest."""

    index: bytes  # index.hgs
    pages: Mapping[str, bytes]  # id -> page, in order of time; none for a short scene: its index is its manifest

    def packed(self, manifest: bytes) -> bytes:
        """Return all in one, for the manifest with these bytes."""
        lengths = [len(self.index), *map(len, self.pages.values())]
        head = np.array([len(lengths), *lengths], "<u4").tobytes()
        return b"".join((hashlib.sha256(manifest).digest(), head, self.index, *self.pages.values()))

    @classmethod
    def unpacked(cls, data: bytes, manifest: bytes) -> PagedScene | None:
        """Undo `packed`; None if that was of another manifest, or is damaged."""
        if len(data) < 36 or data[:32] != hashlib.sha256(manifest).digest():
            return None
        count = int(np.frombuffer(data, "<u4", 1, 32)[0])
        if not 0 < count <= (len(data) - 36) // 4:
            return None
        parts = []
        at = 36 + 4 * count
        for length in np.frombuffer(data, "<u4", count, 36).tolist():
            parts.append(data[at : at + length])
            at += length
        return (
            cls(parts[0], {hashlib.sha256(page).hexdigest(): page for page in parts[1:]}) if at == len(data) else None
        )


def paged(manifest: Manifest, document: Mapping[str, Any], full: int = PAGE, short: int = WHOLE) -> PagedScene:
    """Put a manifest, given also as plain JSON, into pages; equal manifests give equal pages.

    A page takes segments until it has `full` chunks; a scene with up to `short` chunks that move has none.

    Versions of a scene that grows have the same pages, but the last one of each, which is not full. It has pages from
    the beginning, so that no version takes away what an earlier one had.
    """
    groups = _groups(manifest, full)
    if not groups or (manifest.live is None and sum(len(piece.chunks) for piece in manifest.slices) <= short):
        return PagedScene(_packed(document), {})
    pieces = _pieces_of(manifest, [group[0].start for group in groups])
    pages: dict[str, bytes] = {}
    rows = []
    first = 0
    for place, (group, sounds) in enumerate(zip(groups, pieces, strict=True)):
        last = len(manifest.segments) if place == len(groups) - 1 else group[-1].segment + 1
        data = _page(manifest.segments[first:last], group, first, sounds)
        name = hashlib.sha256(data).hexdigest()
        pages[name] = data
        rows.append({"id": name, "bytes": len(data), "start": group[0].start, "segments": last - first})
        first = last
    header = {name: value for name, value in document.items() if name not in ("segments", "slices")}
    if manifest.audio is not None:
        header["audio"] = {name: value for name, value in document["audio"].items() if name != "pieces"}
    index = {
        "format": INDEX_FORMAT,
        "version": INDEX_VERSION,
        "manifest": header,
        "pages": rows,
        "room": _room(manifest.slices),
    }
    return PagedScene(_packed(index), pages)


def _groups(manifest: Manifest, full: int) -> list[list[SliceEntry]]:
    """Return the slices of every page; none where slices are not in the order of their segments."""
    groups: list[list[SliceEntry]] = []
    count = full
    for before, piece in zip((None, *manifest.slices), manifest.slices, strict=False):
        if before is not None and piece.segment < before.segment:
            return []
        if count >= full and (before is None or piece.segment > before.segment):
            groups.append([])
            count = 0
        groups[-1].append(piece)
        count += len(piece.chunks)
    return groups


def _pieces_of(manifest: Manifest, starts: Sequence[float]) -> list[list[AudioPiece]]:
    """Return the pieces of sound that begin in the time of each page; of a scene that grows none beyond its edge."""
    pieces = () if manifest.audio is None else manifest.audio.pieces
    found: list[list[AudioPiece]] = [[] for _ in starts]
    page = 0
    for piece in pieces:
        if manifest.live is not None and piece.start >= manifest.end:
            break
        while page + 1 < len(starts) and starts[page + 1] <= piece.start:
            page += 1
        found[page].append(piece)
    return found


def _page(
    segments: Sequence[SegmentEntry], slices: Sequence[SliceEntry], first: int, pieces: Sequence[AudioPiece]
) -> bytes:
    chunks = [chunk for piece in slices for chunk in piece.chunks]
    place = {chunk.id: number for number, chunk in enumerate(chunks)}
    counts = [0] * len(segments)
    for piece in slices:
        counts[piece.segment - first] += 1
    needs = [place[name] for piece in slices for name in piece.needs]
    spans: list[float] = []
    for entries in (segments, slices, pieces):
        spans += [entry.start for entry in entries] + [entry.end for entry in entries]
    wholes = [
        *counts,
        *(len(piece.chunks) for piece in slices),
        *(len(piece.needs) for piece in slices),
        *needs,
        *(chunk.bytes for chunk in chunks),
        *(chunk.splats for chunk in chunks),
        *(piece.bytes for piece in pieces),
    ]
    raw = b"".join(
        (
            MAGIC,
            np.array([len(segments), len(slices), len(chunks), len(needs), len(pieces)], "<u4").tobytes(),
            np.array(spans, "<f8").tobytes(),
            _outward([chunk.box for chunk in chunks]),
            np.array(wholes, "<u4").tobytes(),
            *(bytes.fromhex(chunk.id) for chunk in chunks),
            *(bytes.fromhex(piece.id) for piece in pieces),
        )
    )
    return gzip.compress(raw, _LEVEL, mtime=0)


def _outward(boxes: Sequence[Box]) -> bytes:
    """Return boxes as f32, none of them smaller than it was."""
    exact = np.array(boxes, "f8").reshape(-1, 2, 3)
    rounded = exact.astype("<f4")
    low, high = rounded[:, 0], rounded[:, 1]
    rounded[:, 0] = np.where(low > exact[:, 0], np.nextafter(low, np.float32(-np.inf)), low)
    rounded[:, 1] = np.where(high < exact[:, 1], np.nextafter(high, np.float32(np.inf)), high)
    return rounded.tobytes()


def _room(slices: Sequence[SliceEntry]) -> dict[str, int]:
    """Return how many chunks move, and the most of them, and splats, that two slices need that follow each other."""
    splats = {chunk.id: chunk.splats for piece in slices for chunk in piece.chunks}
    pairs = [
        {name for one in (piece, slices[(k + 1) % len(slices)]) for name in (*one.needs, *(c.id for c in one.chunks))}
        for k, piece in enumerate(slices)
    ]
    return {
        "chunks": len(splats),
        "most_chunks": max(len(pair) for pair in pairs),
        "most_splats": max(sum(splats[name] for name in pair) for pair in pairs),
    }


def _packed(document: Mapping[str, Any]) -> bytes:
    return gzip.compress(json.dumps(document, separators=(",", ":")).encode(), _LEVEL, mtime=0)
