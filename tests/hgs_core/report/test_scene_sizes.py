from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec import load_manifest
from hgs_core.codec.format.attributes import Kind
from hgs_core.report.scene_sizes import CONTAINER, chunk_sizes
from hgs_core.runs.run_folder import RunFolder


def test_streams_of_all_chunks_add_up_to_their_files(run: Path) -> None:
    folder = RunFolder(run)
    manifest = load_manifest(folder.manifest)
    sizes = chunk_sizes(folder, manifest)
    assert [sum(size.streams.values()) for size in sizes] == [chunk.bytes for chunk in manifest.chunks]
    assert [size.splats for size in sizes] == [chunk.splats for chunk in manifest.chunks]


def test_static_chunks_come_first_and_dynamic_ones_know_their_slice(run: Path) -> None:
    manifest = load_manifest(RunFolder(run).manifest)
    sizes = chunk_sizes(RunFolder(run), manifest)
    expected = [(Kind.STATIC, -1)] * len(manifest.static)
    expected += [(Kind.DYNAMIC, k) for k, piece in enumerate(manifest.slices) for _ in piece.chunks]
    assert [(size.kind, size.slice) for size in sizes] == expected
    assert {"position", "rgb", CONTAINER} <= set(sizes[0].streams)
    assert all(min(size.streams.values()) > 0 for size in sizes)


@pytest.mark.parametrize("damage", ["missing", "cut"])
def test_a_chunk_that_cannot_be_read_is_named_with_its_cure(run: Path, tmp_path: Path, damage: str) -> None:
    folder = RunFolder(tmp_path / "run")
    shutil.copytree(run, folder.path)
    manifest = load_manifest(folder.manifest)
    file = folder.scene / "chunks" / manifest.static[0].id
    if damage == "missing":
        file.unlink()
    else:
        file.write_bytes(file.read_bytes()[:40])
    with pytest.raises(InputError, match=rf"{file.name}: .*; encode the scene again"):
        chunk_sizes(folder, manifest)
