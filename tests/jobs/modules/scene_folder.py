"""Writes small scene folders."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np

from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry
from hgs_core.scene.camera import Camera
from tests.chunks import splats_of, static_chunk

ONE, TWO = static_chunk(b"one"), static_chunk(b"two")


def name_of(data: bytes) -> str:
    """Return the id of a chunk."""
    return hashlib.sha256(data).hexdigest()


def write_scene(folder: Path, chunks: tuple[bytes, ...] = (ONE, TWO), title: str = "Scene") -> list[str]:
    """Write a scene folder of these static chunks and return their ids."""
    (folder / "chunks").mkdir(parents=True, exist_ok=True)
    box = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    entries = [ChunkEntry(name_of(data), len(data), splats_of(data), box) for data in chunks]
    for entry, data in zip(entries, chunks, strict=True):
        (folder / "chunks" / entry.id).write_bytes(data)
    (folder / "thumbnail.jpg").write_bytes(b"a picture")
    manifest = Manifest(
        title=title,
        start=0.0,
        end=0.0,
        frame_rate=30.0,
        background=(0.0, 0.0, 0.0),
        up=(0.0, 1.0, 0.0),
        center=(0.0, 0.0, 0.0),
        extent=1.0,
        cameras=(Camera("cam00", 16, 16, 16.0, 16.0, 8.0, 8.0, np.eye(4)),),
        segments=(SegmentEntry(0.0, 0.0),),
        static=tuple(entries),
        slices=(SliceEntry(0, 0.0, 0.0, (), ()),),
        thumbnail=True,
        training={},
    )
    temporary = folder / "manifest.tmp"
    temporary.write_text(json.dumps(manifest.to_json()))
    temporary.replace(folder / "manifest.json")
    return [entry.id for entry in entries]
