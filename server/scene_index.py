"""What the server must know of a scene to stream it: its chunks, their sizes and times."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

from hgs_core.base.errors import InputError
from hgs_core.codec.format.growth import continues, growth_of
from hgs_core.codec.format.layers import SLICE_PART, STATIC_PART, layers
from hgs_core.codec.format.manifest import Manifest
from server.scene_opening import opening
from server.slice_queue import SliceQueue

__all__ = ["Chunk", "SceneIndex", "Slice", "read_scene"]


@dataclass(frozen=True)
class Chunk:
    """What a manifest says of a chunk."""

    id: bytes  # the 32 bytes of its SHA-256
    size: int  # bytes
    layer: int = 0  # 0 is the base of its list
    splats: int = 0


@dataclass(frozen=True)
class Slice:
    """A stretch of time, shown for start <= t < end in seconds, and all chunks it needs, in the order of sending."""

    start: float
    end: float
    chunks: tuple[Chunk, ...]

    @cached_property
    def base(self) -> tuple[Chunk, ...]:
        """What must be there before the slice is entered."""
        return tuple(chunk for chunk in self.chunks if chunk.layer == 0)

    @cached_property
    def refinements(self) -> tuple[Chunk, ...]:
        """What is added while the slice is shown."""
        return tuple(chunk for chunk in self.chunks if chunk.layer > 0)


@dataclass(frozen=True)
class SceneIndex:
    """A published scene as the stream and the list of scenes see it."""

    scene_id: str
    title: str
    manifest: bytes  # the exact bytes of manifest.json
    start: float  # seconds
    end: float
    static: tuple[Chunk, ...]  # in layer order
    slices: tuple[Slice, ...]  # in order of time
    splats_static: int
    splats_dynamic: int
    live: int | None = None  # the number of the manifest of a scene that grows; None: it is complete
    sounds: tuple[Slice, ...] = ()  # pieces of sound in order of time, each of one chunk
    opening: SceneIndex | None = None  # of the beginning of a long scene, of which this is a later version

    @cached_property
    def chunk_ids(self) -> frozenset[str]:
        """The ids of all chunks, hex."""
        return frozenset(name.hex() for name in self.stored)

    @cached_property
    def stored(self) -> Mapping[bytes, int]:
        """The size of every distinct chunk by id, of splats and of sound."""
        return {**self.sizes, **{piece.chunks[0].id: piece.chunks[0].size for piece in self.sounds}}

    @cached_property
    def sizes(self) -> Mapping[bytes, int]:
        """The size of every distinct chunk of splats by id."""
        chunks = (*self.static, *(chunk for piece in self.slices for chunk in piece.chunks))
        return {chunk.id: chunk.size for chunk in chunks}

    @cached_property
    def chunk_bytes(self) -> int:
        """The size of all chunks of splats together."""
        return sum(self.sizes.values())

    @cached_property
    def sound_bytes(self) -> int:
        """The size of all sound."""
        return sum(self.stored.values()) - self.chunk_bytes

    @cached_property
    def manifest_id(self) -> bytes:
        """The SHA-256 of the manifest's bytes."""
        return hashlib.sha256(self.manifest).digest()

    @cached_property
    def queue(self) -> SliceQueue:
        """All slices, to be asked by time; sessions take slices out of copies."""
        return SliceQueue([piece.end for piece in self.slices])

    @property
    def bytes_total(self) -> int:
        """The size of the whole scene: its chunks and its manifest."""
        return self.chunk_bytes + self.sound_bytes + len(self.manifest)

    def growth(self, earlier: SceneIndex) -> bytes | None:
        """Return as JSON what makes this manifest of that of an earlier index; None if it is another scene's."""
        return _growth(self.manifest, earlier.manifest)

    def alive(self, time: float) -> list[int]:
        """Return the indices of the slices that are shown at `time`, in seconds."""
        found = []
        index = self.queue.first_shown_after(time)
        while index is not None and self.slices[index].start <= time:
            found.append(index)
            index = self.queue.first_shown_after(time, index + 1)
        return found


@lru_cache(maxsize=16)  # all who watch a scene ask for the same
def _growth(later: bytes, earlier: bytes) -> bytes | None:
    after, before = json.loads(later), json.loads(earlier)
    if not continues(after, before):
        return None
    return json.dumps(growth_of(after, before), separators=(",", ":")).encode()


def read_scene(scene_id: str, manifest: bytes) -> SceneIndex:
    """Read what the server needs from the bytes of a manifest.

    Raises:
        InputError: the manifest is not one that this version understands.
    """
    try:
        document = json.loads(manifest)
    except (ValueError, RecursionError) as error:
        raise InputError(f"manifest of scene {scene_id}", f"is not JSON: {error}") from error
    described = Manifest.from_json(document, f"manifest of scene {scene_id}")
    beginning = opening(document, described, len(manifest))
    if beginning is not None:
        _growth(manifest, beginning)  # here it makes nobody wait
    chunks: dict[str, Chunk] = {}
    for entries, part in ((described.static, STATIC_PART), *((piece.chunks, SLICE_PART) for piece in described.slices)):
        for entry, layer in zip(entries, layers([entry.bytes for entry in entries], part), strict=True):
            chunks[entry.id] = Chunk(bytes.fromhex(entry.id), entry.bytes, layer, entry.splats)
    return SceneIndex(
        scene_id=scene_id,
        title=described.title,
        manifest=manifest,
        start=described.start,
        end=described.end,
        static=tuple(chunks[entry.id] for entry in described.static),
        slices=tuple(
            Slice(piece.start, piece.end, tuple(chunks[name] for name in (*piece.needs, *(c.id for c in piece.chunks))))
            for piece in described.slices
        ),
        splats_static=described.totals.splats_static,
        splats_dynamic=described.totals.splats_dynamic,
        live=described.live,
        sounds=tuple(
            Slice(piece.start, piece.end, (Chunk(bytes.fromhex(piece.id), piece.bytes),))
            for piece in (described.audio.pieces if described.audio is not None else ())
        ),
        opening=None if beginning is None else read_scene(scene_id, beginning),
    )
