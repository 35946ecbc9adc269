"""A small scene and a store that holds it, for the tests of the server."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence

import pytest

from server.scene_index import Chunk, SceneIndex, Slice

SliceSpec = tuple[float, float, Sequence[int]]  # start, end, sizes of the chunks


def chunk_bytes(name: str, size: int) -> bytes:
    """Return `size` bytes that no other name gives."""
    seed = hashlib.sha256(name.encode()).digest()
    return (seed * (size // 32 + 1))[:size]


@pytest.fixture
def make_scene() -> Callable[[Sequence[int], Sequence[SliceSpec]], SceneIndex]:
    """Return a function that builds a scene of static chunks of the given sizes and of slices."""

    def make(static: Sequence[int], slices: Sequence[SliceSpec]) -> SceneIndex:
        def chunk(name: str, size: int) -> Chunk:
            return Chunk(hashlib.sha256(chunk_bytes(name, size)).digest(), size)

        pieces = tuple(
            Slice(start, end, tuple(chunk(f"slice {i} chunk {k}", size) for k, size in enumerate(sizes)))
            for i, (start, end, sizes) in enumerate(slices)
        )
        return SceneIndex(
            scene_id="studio",
            manifest=b'{"a": "manifest"}',
            start=min((s for s, _, _ in slices), default=0.0),
            end=max((e for _, e, _ in slices), default=0.0),
            static=tuple(chunk(f"static {k}", size) for k, size in enumerate(static)),
            slices=pieces,
        )

    return make
