"""What the server must know of a scene to stream it: its chunks, their sizes and times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

__all__ = ["Chunk", "SceneIndex", "Slice"]


@dataclass(frozen=True)
class Chunk:
    """A chunk's id, the 32 bytes of its SHA-256, and its size in bytes."""

    id: bytes
    size: int


@dataclass(frozen=True)
class Slice:
    """The dynamic chunks of one interval of time, [start, end] in seconds, in the order in which they are sent."""

    start: float
    end: float
    chunks: tuple[Chunk, ...]


@dataclass(frozen=True)
class SceneIndex:
    """A published scene as the stream sees it; slices by start, then end."""

    scene_id: str
    manifest: bytes  # the exact bytes of manifest.json
    start: float  # seconds
    end: float
    static: tuple[Chunk, ...]  # in layer order
    slices: tuple[Slice, ...]
    splats_static: int = 0
    splats_dynamic: int = 0
    title: str = ""

    @cached_property
    def sizes(self) -> Mapping[bytes, int]:
        """The size of every distinct chunk by id."""
        chunks = (*self.static, *(chunk for piece in self.slices for chunk in piece.chunks))
        return {chunk.id: chunk.size for chunk in chunks}

    @property
    def bytes_total(self) -> int:
        """The size of the whole scene: its chunks and its manifest."""
        return sum(self.sizes.values()) + len(self.manifest)

    def alive(self, time: float) -> list[int]:
        """Return the indices of the slices that are shown at `time`, in seconds."""
        return [index for index, piece in enumerate(self.slices) if piece.start <= time <= piece.end]
