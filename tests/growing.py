"""A small scene that grows, as a folder that can be published: three segments of a second, with a chunk each."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from hgs_core.codec.format.growth import first_segments
from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry
from hgs_core.scene.camera import Camera
from tests.chunks import dynamic_chunk, splats_of, static_chunk

SEGMENTS = 3
STATIC = static_chunk(b"room")
MOVING = [dynamic_chunk(b"segment %d" % k, (float(k), k + 1.0)) for k in range(SEGMENTS)]


def write_growing_scene(folder: Path, segments: int) -> bytes:
    """Write the scene as it is when it has its first so many segments; returns the bytes of its manifest."""
    (folder / "chunks").mkdir(parents=True, exist_ok=True)
    for data in (STATIC, *MOVING[:segments]):
        (folder / "chunks" / hashlib.sha256(data).hexdigest()).write_bytes(data)
    manifest = json.dumps(first_segments(growing_manifest(STATIC, MOVING), segments).to_json()).encode()
    (folder / "manifest.json").write_bytes(manifest)
    return manifest


def growing_manifest(static: bytes, moving: Sequence[bytes], live: int | None = None) -> Manifest:
    """Return the manifest of a scene with one chunk of statics and one of every segment, each of a second."""
    box = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))

    def entry(data: bytes) -> ChunkEntry:
        return ChunkEntry(hashlib.sha256(data).hexdigest(), len(data), splats_of(data), box)

    return Manifest(
        title="Growing",
        start=0.0,
        end=float(len(moving)),
        frame_rate=30.0,
        background=(0.0, 0.0, 0.0),
        up=(0.0, -1.0, 0.0),
        center=(0.0, 0.0, 0.0),
        extent=1.0,
        cameras=(Camera("cam00", 64, 48, 50.0, 50.0, 32.0, 24.0, np.eye(4)),),
        segments=tuple(SegmentEntry(float(k), k + 1.0) for k in range(len(moving))),
        static=(entry(static),),
        slices=tuple(SliceEntry(k, float(k), k + 1.0, (entry(data),), ()) for k, data in enumerate(moving)),
        thumbnail=False,
        training={},
        live=live,
    )
