"""The scene `studio` of the tests: five chunks of bytes, its manifest, and a run folder that holds it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry
from hgs_core.scene.camera import Camera
from tests.chunks import dynamic_chunk, splats_of, static_chunk

__all__ = ["chunk_bytes", "chunks", "manifest", "scene_folder", "small_manifest"]


def chunk_bytes(name: str, size: int) -> bytes:
    """Return `size` bytes that no other name gives."""
    seed = hashlib.sha256(name.encode()).digest()
    return (seed * (size // 32 + 1))[:size]


def small_manifest(static: Sequence[bytes], slices: Sequence[tuple[float, float, Sequence[bytes]]]) -> Manifest:
    """Return the manifest of a scene of the given chunks; each slice after the first needs the one before it."""
    box = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))

    def entry(data: bytes) -> ChunkEntry:
        return ChunkEntry(hashlib.sha256(data).hexdigest(), len(data), splats_of(data), box)

    pieces: list[SliceEntry] = []
    for start, end, chunks in slices:
        needs = tuple(chunk.id for chunk in pieces[-1].chunks) if pieces else ()
        pieces.append(SliceEntry(0, start, end, tuple(map(entry, chunks)), needs))
    return Manifest(
        title="Studio",
        start=slices[0][0],
        end=slices[-1][1],
        frame_rate=30.0,
        background=(0.0, 0.0, 0.0),
        up=(0.0, -1.0, 0.0),
        center=(0.0, 0.0, 0.0),
        extent=1.0,
        cameras=(Camera("cam00", 64, 48, 50.0, 50.0, 32.0, 24.0, np.eye(4)),),
        segments=(SegmentEntry(slices[0][0], slices[-1][1]),),
        static=tuple(map(entry, static)),
        slices=tuple(pieces),
        thumbnail=True,
        training={},
    )


@pytest.fixture
def chunks() -> list[bytes]:
    """The chunks of the scene `studio`: two static layers, then one chunk in each of its three slices."""
    contents = [chunk_bytes(f"chunk {k}", size) for k, size in enumerate((150_000, 80_000, 70_000, 9_000, 5_000))]
    return [static_chunk(content) for content in contents[:2]] + [
        dynamic_chunk(content, (0.0, 3.0)) for content in contents[2:]
    ]


@pytest.fixture
def manifest(chunks: list[bytes]) -> bytes:
    """The manifest of the scene `studio`, 0 s to 3 s."""
    slices = [(float(k), k + 1.0, [chunk]) for k, chunk in enumerate(chunks[2:])]
    return json.dumps(small_manifest(chunks[:2], slices).to_json()).encode()


@pytest.fixture
def scene_folder(tmp_path: Path, chunks: list[bytes], manifest: bytes) -> Path:
    """A run folder with the encoded scene `studio`."""
    run = tmp_path / "Studio run"
    (run / "scene" / "chunks").mkdir(parents=True)
    (run / "scene" / "manifest.json").write_bytes(manifest)
    (run / "scene" / "thumbnail.jpg").write_bytes(b"jpeg")
    for chunk in chunks:
        (run / "scene" / "chunks" / hashlib.sha256(chunk).hexdigest()).write_bytes(chunk)
    return run
