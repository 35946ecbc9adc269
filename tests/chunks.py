"""Chunks that decode, of any content and size: chunks of tests/vectors with an attribute of a later version added.

Decoders skip an attribute that they do not know, so what it holds is free. Nothing is encoded, so this is quick.
"""

from __future__ import annotations

import dataclasses
from functools import cache
from pathlib import Path

from hgs_core.codec.format.chunk import Container, Stream, pack, unpack
from hgs_core.codec.format.quantise import Grid

VECTORS = Path(__file__).parent / "vectors"
UNKNOWN = 200  # no attribute of docs/format.md


def static_chunk(content: bytes) -> bytes:
    """Return a chunk with one static splat."""
    return _with_content(_vector("static_one"), content)


def dynamic_chunk(content: bytes, time_range: tuple[float, float]) -> bytes:
    """Return a chunk with dynamic splats of a segment of that time, in seconds."""
    return _with_content(dataclasses.replace(_vector("dynamic_still"), time_range=time_range), content)


def splats_of(chunk: bytes) -> int:
    """Return how many splats a chunk has."""
    return unpack(chunk).count


@cache
def _vector(name: str) -> Container:
    return unpack((VECTORS / f"{name}.chunk").read_bytes())


def _with_content(container: Container, content: bytes) -> bytes:
    unknown = Stream(UNKNOWN, 1, 0, Grid(1.0, (0,), 8), (memoryview(content),))
    return pack(dataclasses.replace(container, streams=(*container.streams, unknown)))
