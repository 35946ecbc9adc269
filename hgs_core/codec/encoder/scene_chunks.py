"""The chunks of a scene with their entries in the manifest."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from hgs_core.codec.format.decode import DecodedChunk
from hgs_core.codec.format.manifest import ChunkEntry, SliceEntry
from hgs_core.codec.format.scene_folder import chunk_id

__all__ = ["CodedChunk", "SceneChunks"]


@dataclass(frozen=True)
class CodedChunk:
    """A chunk's bytes with its entry in the manifest."""

    entry: ChunkEntry
    data: bytes
    version: int

    @classmethod
    def of(cls, data: bytes, decoded: DecodedChunk) -> CodedChunk:
        """Return the chunk of these bytes, which decode so."""
        return cls(ChunkEntry(chunk_id(data), len(data), decoded.count, decoded.box), data, decoded.version)


@dataclass(frozen=True)
class SceneChunks:
    """All chunks of a scene; `moving` in the order of the slices."""

    static: tuple[CodedChunk, ...]
    moving: tuple[CodedChunk, ...]
    slices: tuple[SliceEntry, ...]

    def __iter__(self) -> Iterator[CodedChunk]:
        """Iterate over static chunks, then moving ones."""
        yield from self.static
        yield from self.moving
