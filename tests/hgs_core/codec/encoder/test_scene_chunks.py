from __future__ import annotations

import hashlib
from pathlib import Path

from hgs_core.codec import decode_chunk, load_manifest
from hgs_core.codec.encoder.scene_chunks import CodedChunk, SceneChunks
from hgs_core.codec.format.scene_folder import chunk_bytes
from hgs_core.scene.camera import Camera
from tests.hgs_core.codec.scenes import encode, scene


def test_the_entry_of_a_chunk_is_told_by_its_bytes(tmp_path: Path, cameras: list[Camera]) -> None:
    manifest = encode(scene(), tmp_path, cameras)
    data = {entry.id: chunk_bytes(tmp_path, entry) for entry in manifest.chunks}
    coded = {name: CodedChunk.of(content, decode_chunk(content)) for name, content in data.items()}
    assert [one.entry for one in coded.values()] == list(load_manifest(tmp_path).chunks)
    assert all(hashlib.sha256(one.data).hexdigest() == name for name, one in coded.items())
    static = tuple(coded[entry.id] for entry in manifest.static)
    moving = tuple(one for one in coded.values() if one not in static)
    assert [one.entry for one in SceneChunks(static, moving, manifest.slices)] == list(manifest.chunks)
