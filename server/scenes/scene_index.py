"""Index of a scene for streaming: its chunks with their sizes and times."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from hgs_core.base.errors import InputError
from hgs_core.codec.format.layers import SLICE_PART, STATIC_PART, layers
from hgs_core.codec.format.manifest import ChunkEntry, Manifest
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.paged_manifest import PagedManifest, read_index
from hgs_core.codec.format.pages import Columns, read_columns
from hgs_core.codec.format.paging import PagedScene, paged
from server.scenes.slice_queue import SliceQueue

__all__ = ["Chunk", "SceneIndex", "Slice", "read_scene"]


@dataclass(frozen=True)
class Chunk:
    """A manifest's entry of a chunk."""

    id: bytes  # SHA-256, 32 bytes
    size: int  # bytes
    layer: int = 0  # 0 is the base of its list
    splats: int = 0


@dataclass(frozen=True)
class Slice:
    """A stretch of time, shown for start <= t < end in seconds, and all its chunks in sending order."""

    start: float
    end: float
    chunks: tuple[Chunk, ...]

    @cached_property
    def base(self) -> tuple[Chunk, ...]:
        """Chunks required before the slice is shown."""
        return tuple(chunk for chunk in self.chunks if chunk.layer == 0)

    @cached_property
    def refinements(self) -> tuple[Chunk, ...]:
        """Chunks added while the slice is shown."""
        return tuple(chunk for chunk in self.chunks if chunk.layer > 0)


@dataclass(frozen=True)
class SceneIndex:
    """Index of a published scene, for the stream and the list of scenes.

    The manifest of a long scene is split into pages, themselves chunks: a slice's first chunk is its page.
    """

    scene_id: str
    title: str
    manifest: bytes  # the bytes of index.hgs, which clients receive
    start: float  # seconds
    end: float
    static: tuple[Chunk, ...]  # layer order
    slices: tuple[Slice, ...]  # time order
    splats_static: int
    splats_dynamic: int
    live: int | None = None  # number of a growing scene's manifest; None: the scene is complete
    sounds: tuple[Slice, ...] = ()  # pieces of sound by time, one chunk each
    pages: tuple[Slice, ...] = ()  # pages of the manifest by time, one chunk each
    page_bytes: Mapping[bytes, bytes] = field(default_factory=dict)  # contents of the pages, by id
    page_chunks: Mapping[bytes, tuple[bytes, ...]] = field(default_factory=dict)  # chunk ids listed in the pages, by id
    document: bytes = b""  # the exact bytes of manifest.json
    poster_shape: float | None = None  # width / height of the first camera, if there is a thumbnail

    @cached_property
    def whole(self) -> SceneIndex:
        """The same scene without pages, for a client that fetches manifest.json."""
        slices = self.slices
        if self.pages:
            slices = tuple(Slice(piece.start, piece.end, piece.chunks[1:]) for piece in slices)
        return replace(self, manifest=self.document, slices=slices, pages=(), page_bytes={}, page_chunks={})

    @cached_property
    def chunk_ids(self) -> frozenset[str]:
        """Ids of all chunks, hex."""
        return frozenset(name.hex() for name in self.stored)

    @cached_property
    def stored(self) -> Mapping[bytes, int]:
        """Sizes of all distinct chunks of splats and sound, by id."""
        return {**self.sizes, **{piece.chunks[0].id: piece.chunks[0].size for piece in self.sounds}}

    @cached_property
    def sizes(self) -> Mapping[bytes, int]:
        """Sizes of all distinct chunks of splats and of all pages, by id."""
        chunks = (*self.static, *(chunk for piece in self.slices for chunk in piece.chunks))
        return {chunk.id: chunk.size for chunk in chunks}

    @cached_property
    def manifest_id(self) -> bytes:
        """SHA-256 of the manifest in the form sent to clients."""
        return hashlib.sha256(self.manifest).digest()

    @cached_property
    def queue(self) -> SliceQueue:
        """Queue of all slices by time; sessions remove slices from copies."""
        return SliceQueue([piece.end for piece in self.slices])

    @property
    def bytes_total(self) -> int:
        """Size of the whole scene: its chunks and its manifest, bytes."""
        return sum(self.stored.values()) - sum(map(len, self.page_bytes.values())) + len(self.document)

    def alive(self, time: float) -> list[int]:
        """Return the indices of the slices shown at `time`, in seconds."""
        found = []
        index = self.queue.first_shown_after(time)
        while index is not None and self.slices[index].start <= time:
            found.append(index)
            index = self.queue.first_shown_after(time, index + 1)
        return found


def read_scene(scene_id: str, manifest: bytes, ready: PagedScene | None = None) -> SceneIndex:
    """Build the index of a scene from its manifest, or from pages split earlier.

    Raises:
        InputError: the manifest is invalid or of an unsupported version.
    """
    if ready is None:
        document, described = _described(scene_id, manifest)
        ready = paged(described, document)
        if not ready.pages:
            return _short(scene_id, manifest, ready.index, described)
    index = read_index(ready.index, f"index of scene {scene_id}")
    header = PagedManifest(index, f"index of scene {scene_id}")
    rows = [(entry, read_columns(data)) for entry, data in zip(header.pages, ready.pages.values(), strict=True)]
    totals = index["manifest"]["totals"]
    return SceneIndex(
        scene_id=scene_id,
        title=header.manifest.title,
        manifest=ready.index,
        start=header.manifest.start,
        end=header.manifest.end,
        static=_layered(header.manifest.static),
        slices=tuple(
            piece for entry, columns in rows for piece in _slices(Chunk(bytes.fromhex(entry.id), entry.bytes), columns)
        ),
        splats_static=totals["splats_static"],
        splats_dynamic=totals["splats_dynamic"],
        live=header.manifest.live,
        sounds=tuple(
            Slice(start, end, (Chunk(name, size),))
            for _, columns in rows
            for (start, end), size, name in zip(
                columns.pieces, columns.piece_bytes, columns.ids[len(columns.boxes) :], strict=True
            )
        ),
        pages=tuple(
            Slice(columns.slices[0][0], columns.slices[-1][1], (Chunk(bytes.fromhex(entry.id), entry.bytes),))
            for entry, columns in rows
        ),
        page_bytes={bytes.fromhex(name): data for name, data in ready.pages.items()},
        page_chunks={bytes.fromhex(entry.id): tuple(columns.ids) for entry, columns in rows},
        document=manifest,
        poster_shape=_poster_shape(header.manifest),
    )


def _poster_shape(manifest: Manifest) -> float | None:
    if not manifest.thumbnail or not manifest.cameras:
        return None
    return manifest.cameras[0].width / manifest.cameras[0].height


def _described(scene_id: str, manifest: bytes) -> tuple[Mapping[str, object], Manifest]:
    where = f"manifest of scene {scene_id}"
    try:
        document = json.loads(manifest)
    except (ValueError, RecursionError) as error:
        raise InputError(where, f"is not JSON: {error}") from error
    return document, read_manifest(document, where)


def _short(scene_id: str, manifest: bytes, index: bytes, described: Manifest) -> SceneIndex:
    moving = {entry.id: chunk for piece in described.slices for entry, chunk in _named(piece.chunks)}
    return SceneIndex(
        scene_id=scene_id,
        title=described.title,
        manifest=index,
        start=described.start,
        end=described.end,
        static=_layered(described.static),
        slices=tuple(
            Slice(piece.start, piece.end, tuple(moving[name] for name in (*piece.needs, *(c.id for c in piece.chunks))))
            for piece in described.slices
        ),
        splats_static=described.totals.splats_static,
        splats_dynamic=described.totals.splats_dynamic,
        live=described.live,
        sounds=tuple(
            Slice(piece.start, piece.end, (Chunk(bytes.fromhex(piece.id), piece.bytes),))
            for piece in (described.audio.pieces if described.audio is not None else ())
        ),
        document=manifest,
        poster_shape=_poster_shape(described),
    )


def _layered(entries: Iterable[ChunkEntry]) -> tuple[Chunk, ...]:
    return tuple(chunk for _, chunk in _named(tuple(entries), STATIC_PART))


def _named(entries: tuple[ChunkEntry, ...], part: int = SLICE_PART) -> list[tuple[ChunkEntry, Chunk]]:
    return [
        (entry, Chunk(bytes.fromhex(entry.id), entry.bytes, layer, entry.splats))
        for entry, layer in zip(entries, layers([entry.bytes for entry in entries], part), strict=True)
    ]


def _slices(page: Chunk, columns: Columns) -> list[Slice]:
    chunks: list[Chunk] = []
    found = []
    needed = 0
    for (start, end), own, needs in zip(columns.slices, columns.slice_chunks, columns.slice_needs, strict=True):
        sizes = columns.chunk_bytes[len(chunks) : len(chunks) + own]
        before = [chunks[place] for place in columns.needs[needed : needed + needs]]
        needed += needs
        for size, layer in zip(sizes, layers(sizes, SLICE_PART), strict=True):
            place = len(chunks)
            chunks.append(Chunk(columns.ids[place], size, layer, columns.chunk_splats[place]))
        found.append(Slice(start, end, (page, *before, *chunks[len(chunks) - own :])))
    return found
