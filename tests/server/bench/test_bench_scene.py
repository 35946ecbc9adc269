from __future__ import annotations

import json
from pathlib import Path

from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.scene_folder import CHUNKS, MANIFEST
from server.bench.bench_scene import made_up_scene, scene_of

SCENE = made_up_scene(2, static_bytes=60_000, slice_bytes=9_000)


def test_made_up_scene_is_one_that_readers_take() -> None:
    assert read_manifest(json.loads(SCENE.document)).to_json() == SCENE.manifest.to_json()
    assert set(SCENE.chunks) == {entry.id for entry in SCENE.manifest.chunks}
    assert SCENE.rate == 8 * 4 * 9_000 / 2


def test_scene_folder_is_read(tmp_path: Path) -> None:
    (tmp_path / CHUNKS).mkdir()
    (tmp_path / MANIFEST).write_bytes(SCENE.document)
    for name, data in SCENE.chunks.items():
        (tmp_path / CHUNKS / name).write_bytes(data)
    read = scene_of(tmp_path)
    assert (read.document, read.chunks, read.size) == (SCENE.document, SCENE.chunks, SCENE.size)
