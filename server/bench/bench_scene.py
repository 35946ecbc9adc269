"""A scene for benches of the server, read from a folder or made up of random bytes."""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.codec.format.manifest import ChunkEntry, Manifest, SegmentEntry, SliceEntry
from hgs_core.codec.format.paging import PagedScene, paged
from hgs_core.codec.format.scene_folder import CHUNKS, MANIFEST, load_manifest
from hgs_core.scene.camera import Camera

__all__ = ["BenchScene", "made_up_scene", "scene_of"]


@dataclass(frozen=True)
class BenchScene:
    """A scene to be served."""

    manifest: Manifest
    document: bytes  # manifest.json
    chunks: Mapping[str, bytes]

    @property
    def size(self) -> int:
        """Bytes of all chunks and of the manifest."""
        return len(self.document) + sum(map(len, self.chunks.values()))

    @cached_property
    def pages(self) -> PagedScene:
        """The manifest in pages, as publishing makes them."""
        return paged(self.manifest, json.loads(self.document))

    @property
    def rate(self) -> float:
        """Bits per second of the dynamic chunks."""
        return 8 * self.manifest.totals.bytes_dynamic / max(self.manifest.end - self.manifest.start, 1e-3)


def scene_of(folder: Path) -> BenchScene:
    """Read a scene folder.

    Raises:
        InputError: it has no manifest of a scene, or a chunk cannot be read.
    """
    manifest = load_manifest(folder)
    chunks = {entry.id: _chunk(folder / CHUNKS / entry.id) for entry in manifest.chunks}
    return BenchScene(manifest, (folder / MANIFEST).read_bytes(), chunks)


def _chunk(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise InputError(file, f"cannot be read: {error.strerror}", "encode the run again") from error


def made_up_scene(seconds: int = 60, *, static_bytes: int = 900_000, slice_bytes: int = 60_000) -> BenchScene:
    """Return a scene of random bytes in segments of 2 s and slices of half a second, each of two chunks."""
    dice, chunks = random.Random(0), {}
    box = ((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))

    def entry(size: int) -> ChunkEntry:
        data = dice.randbytes(size)
        name = hashlib.sha256(data).hexdigest()
        chunks[name] = data
        return ChunkEntry(name, size, max(1, size // 10), box)

    slices: list[SliceEntry] = []
    for place in range(2 * seconds):
        segment, start = place // 4, place / 2
        needs = tuple(piece.chunks[0].id for piece in slices[-2:] if piece.segment == segment)
        slices.append(
            SliceEntry(segment, start, start + 0.5, (entry(slice_bytes * 2 // 3), entry(slice_bytes // 3)), needs)
        )
    manifest = Manifest(
        title="Made up",
        start=0.0,
        end=float(seconds),
        frame_rate=30.0,
        background=(0.0, 0.0, 0.0),
        up=(0.0, -1.0, 0.0),
        center=(0.0, 0.0, 0.0),
        extent=4.0,
        cameras=(Camera("cam00", 640, 360, 500.0, 500.0, 320.0, 180.0, np.eye(4)),),
        segments=tuple(SegmentEntry(2.0 * k, 2.0 * k + 2) for k in range((seconds + 1) // 2)),
        static=tuple(entry(static_bytes // 12) for _ in range(12)),
        slices=tuple(slices),
        thumbnail=False,
        training={},
    )
    return BenchScene(manifest, json.dumps(manifest.to_json(), separators=(",", ":")).encode(), chunks)
