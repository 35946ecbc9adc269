"""Index of a scene for streaming: its chunks with their sizes and times."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from hgs_core.codec.format.layers import SLICE_PART, STATIC_PART, layers
from hgs_core.codec.format.manifest import ChunkEntry, Manifest
from hgs_core.codec.format.manifest_reading import parse_manifest
from hgs_core.codec.format.paged_manifest import PagedManifest, read_index
from hgs_core.codec.format.pages import Columns, read_columns
from hgs_core.codec.format.paging import WHOLE, PagedScene, paged
from server.scenes.slice_queue import SliceQueue

__all__ = ["Chunk", "SceneIndex", "Slice", "read_scene", "read_whole"]


_CHUNK_MEMORY = 600  # bytes of a chunk's entries in all tables, as tracemalloc counts them


@dataclass(frozen=True, slots=True)
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
    manifest: bytes  # the bytes of index.hgs, which clients receive
    start: float  # seconds
    end: float
    static: tuple[Chunk, ...]  # layer order
    slices: tuple[Slice, ...]  # time order
    live: int | None = None  # number of a growing scene's manifest; None: the scene is complete
    sounds: tuple[Slice, ...] = ()  # pieces of sound by time, one chunk each
    pages: tuple[Slice, ...] = ()  # pages of the manifest by time, one chunk each
    page_bytes: Mapping[bytes, bytes] = field(default_factory=dict)  # contents of the pages, by id
    page_chunks: Mapping[bytes, tuple[bytes, ...]] = field(default_factory=dict)  # chunk ids listed in the pages, by id
    document: bytes = b""  # manifest.json of a short scene; none of a long one, the pages of which hold it
    poster_shape: float | None = None  # width / height of the first camera, if there is a thumbnail

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
    def memory(self) -> int:
        """Memory of the index after all of it was used, estimated, bytes."""
        listed = sum(map(len, self.page_chunks.values())) or sum(len(piece.chunks) for piece in self.slices)
        contents = len(self.manifest) + len(self.document) + sum(map(len, self.page_bytes.values()))
        return contents + _CHUNK_MEMORY * (listed + len(self.static))

    def alive(self, time: float) -> list[int]:
        """Return the indices of the slices shown at `time`, in seconds."""
        found = []
        index = self.queue.first_shown_after(time)
        while index is not None and self.slices[index].start <= time:
            found.append(index)
            index = self.queue.first_shown_after(time, index + 1)
        return found


def read_scene(scene_id: str, manifest: bytes, ready: PagedScene | None = None) -> SceneIndex:
    """Build the index of a scene from its manifest, or from pages split earlier if there are any.

    Raises:
        InputError: the manifest is invalid or of an unsupported version.
    """
    if ready is None or not ready.pages:
        document, described = parse_manifest(manifest, f"manifest of scene {scene_id}")
        ready = paged(described, document)
        if not ready.pages:
            return _short(scene_id, manifest, ready.index, described)
    index = read_index(ready.index, f"index of scene {scene_id}")
    header = PagedManifest(index, f"index of scene {scene_id}")
    rows = [(entry, read_columns(data)) for entry, data in zip(header.pages, ready.pages.values(), strict=True)]
    moving = sum(len(columns.chunk_bytes) for _, columns in rows)
    return SceneIndex(
        scene_id=scene_id,
        manifest=ready.index,
        start=header.manifest.start,
        end=header.manifest.end,
        static=_layered(header.manifest.static),
        slices=tuple(
            piece for entry, columns in rows for piece in _slices(Chunk(bytes.fromhex(entry.id), entry.bytes), columns)
        ),
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
        document=manifest if moving <= WHOLE else b"",
        poster_shape=_poster_shape(header.manifest),
    )


def read_whole(scene_id: str, manifest: bytes) -> SceneIndex:
    """Build the index of a scene without pages, for a client that fetches manifest.json.

    Raises:
        InputError: the manifest is invalid or of an unsupported version.
    """
    return _short(scene_id, manifest, manifest, parse_manifest(manifest, f"manifest of scene {scene_id}")[1])


def _poster_shape(manifest: Manifest) -> float | None:
    if not manifest.thumbnail or not manifest.cameras:
        return None
    return manifest.cameras[0].width / manifest.cameras[0].height


def _short(scene_id: str, manifest: bytes, index: bytes, described: Manifest) -> SceneIndex:
    moving = {entry.id: chunk for piece in described.slices for entry, chunk in _named(piece.chunks)}
    return SceneIndex(
        scene_id=scene_id,
        manifest=index,
        start=described.start,
        end=described.end,
        static=_layered(described.static),
        slices=tuple(
            Slice(piece.start, piece.end, tuple(moving[name] for name in (*piece.needs, *(c.id for c in piece.chunks))))
            for piece in described.slices
        ),
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
