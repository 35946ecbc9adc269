from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.artifacts.publish_run import publish_run
from tests.growing import write_growing_scene


@pytest.fixture
def store(tmp_path: Path) -> ArtifactStore:
    return ArtifactStore((tmp_path / "store").as_uri())


def test_scene_is_named_after_the_folder_of_its_run(store: ArtifactStore, scene_folder: Path, manifest: bytes) -> None:
    assert publish_run(store, scene_folder) == "studio-run"
    assert store.manifest("studio-run") == manifest


def test_publishing_again_changes_nothing(store: ArtifactStore, scene_folder: Path) -> None:
    assert publish_run(store, scene_folder) == publish_run(store, scene_folder) == "studio-run"
    assert len(store.list_scenes()) == 1


def test_another_scene_of_the_same_name_gets_an_id_of_its_own(store: ArtifactStore, scene_folder: Path) -> None:
    publish_run(store, scene_folder)
    file = scene_folder / "scene" / "manifest.json"
    file.write_bytes(file.read_bytes().replace(b'"Studio"', b'"Studio 2"'))
    second = publish_run(store, scene_folder)
    assert second.startswith("studio-run-")
    assert publish_run(store, scene_folder) == second
    with pytest.raises(InputError, match="another scene has this id"):
        publish_run(store, scene_folder, "studio-run")


def test_scene_that_has_grown_is_published_in_place_of_what_it_was(store: ArtifactStore, tmp_path: Path) -> None:
    run = tmp_path / "growing"
    for segments in (1, 2, 3):
        manifest = write_growing_scene(run / "scene", segments)
        assert publish_run(store, run) == "growing"
        assert store.manifest("growing") == manifest


def test_run_without_a_scene_is_refused(store: ArtifactStore, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="has no encoded scene"):
        publish_run(store, tmp_path)


def replace_chunk(scene: Path, name: str, data: bytes) -> None:
    """Put other bytes in the place of a chunk, and say so in the manifest."""
    document = json.loads((scene / "manifest.json").read_text())
    lists = {"static": document["static"], "dynamic": [c for piece in document["slices"] for c in piece["chunks"]]}
    (entry,) = (entry for chunks in lists.values() for entry in chunks if entry["id"] == name)
    for piece in document["slices"]:
        piece["needs"] = []
    entry |= {"id": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
    for kind, chunks in lists.items():
        document["totals"][f"bytes_{kind}"] = sum(chunk["bytes"] for chunk in chunks)
    (scene / "chunks" / entry["id"]).write_bytes(data)
    (scene / "manifest.json").write_text(json.dumps(document))


@pytest.mark.parametrize("damage", ["wrong bytes", "missing", "wrong hash in the manifest", "no chunk"])
def test_nothing_of_a_broken_scene_is_published(store: ArtifactStore, scene_folder: Path, damage: str) -> None:
    chunk = sorted((scene_folder / "scene" / "chunks").iterdir())[-1]
    if damage == "wrong bytes":
        chunk.write_bytes(b"damaged")
    elif damage == "missing":
        chunk.unlink()
    elif damage == "no chunk":
        replace_chunk(scene_folder / "scene", chunk.name, b"bytes whose hash and length the manifest states")
    else:
        file = scene_folder / "scene" / "manifest.json"
        file.write_bytes(file.read_bytes().replace(chunk.name.encode(), b"0" * 64))
    with pytest.raises(InputError):
        publish_run(store, scene_folder)
    assert store.list_scenes() == []


def test_malformed_ids_are_refused(store: ArtifactStore, scene_folder: Path) -> None:
    with pytest.raises(InputError, match="scene id"):
        publish_run(store, scene_folder, "../up")
    shutil.rmtree(scene_folder)
