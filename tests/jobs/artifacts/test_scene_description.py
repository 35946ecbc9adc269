from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import obstore
import pytest
from obstore.store import MemoryStore

from hgs_core.base.errors import InputError
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.scene_folder import stored_sizes
from jobs.artifacts import artifact_store
from jobs.artifacts.artifact_store import ArtifactStore, SceneEntry
from jobs.artifacts.scene_description import SceneDescription
from tests.growing import write_growing_scene

DESCRIBED = SceneDescription("Studio", 0.0, 2.0, 812, 20, 8, live=False)


@pytest.fixture
def memory(monkeypatch: pytest.MonkeyPatch) -> MemoryStore:
    memory = MemoryStore()
    monkeypatch.setattr(artifact_store, "open_object_store", lambda url, once: memory)
    return memory


@pytest.fixture
def store(memory: MemoryStore) -> ArtifactStore:
    return ArtifactStore("memory:///")


@pytest.fixture
def reads(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the files that are read."""
    names: list[str] = []
    get = obstore.get

    def counted(store: Any, path: str, **options: Any) -> Any:
        names.append(path.rpartition("/")[2])
        return get(store, path, **options)

    monkeypatch.setattr(obstore, "get", counted)
    return names


def published(store: ArtifactStore, folder: Path, segments: int) -> SceneEntry:
    write_growing_scene(folder, segments)
    store.put_scene(folder, "growing")
    entry = store.scene_entry("growing")
    assert entry is not None
    return entry


def undescribed(store: ArtifactStore, memory: MemoryStore, folder: Path) -> tuple[SceneEntry, SceneDescription | None]:
    """A published scene without its description, and that."""
    entry = published(store, folder, 2)
    right = store.describe(entry)
    obstore.delete(memory, "scenes/growing/description.json")
    return entry, right


def test_the_size_is_of_every_chunk_once_of_sound_and_of_the_manifest(manifest: bytes, chunks: list[bytes]) -> None:
    pieces = [{"id": "a" * 64, "bytes": 5, "start": start, "end": start + 1.0} for start in (0.0, 1.0)]
    audio = {"codec": "opus", "sample_rate": 48000, "channels": 1, "pieces": pieces}
    described = SceneDescription.of(json.loads(manifest) | {"audio": audio}, 100)
    assert described.bytes_total == sum(map(len, chunks)) + 5 + 100
    assert (described.splats_static, described.splats_dynamic) == (2, 60)


@pytest.mark.parametrize("segments", [1, 2, 3])
def test_a_published_scene_is_described_without_its_manifest(
    store: ArtifactStore, tmp_path: Path, reads: list[str], segments: int
) -> None:
    for version in range(1, segments + 1):
        entry = published(store, tmp_path, version)
    reads.clear()
    described = store.describe(entry)
    assert reads == ["description.json"]
    text = store.manifest("growing")
    assert text is not None
    manifest = read_manifest(json.loads(text))
    assert described == SceneDescription(
        "Growing",
        0.0,
        float(segments),
        sum(stored_sizes(manifest).values()) + len(text),
        manifest.totals.splats_static,
        manifest.totals.splats_dynamic,
        live=segments < 3,
    )


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: None,
        lambda data: b"",
        lambda data: b"[]",
        lambda data: b"{}",
        lambda data: data.replace(b'"start"', b'"begin"'),
        lambda data: data.replace(b'"manifest": "', b'"manifest": "another'),
    ],
    ids=["missing", "empty", "list", "bare", "other fields", "of another manifest"],
)
def test_without_a_description_the_manifest_is_read_once(
    store: ArtifactStore,
    memory: MemoryStore,
    tmp_path: Path,
    reads: list[str],
    damage: Callable[[bytes], bytes | None],
) -> None:
    entry = published(store, tmp_path, 2)
    right = store.describe(entry)
    path = "scenes/growing/description.json"
    damaged = damage(bytes(obstore.get(memory, path).bytes()))
    obstore.delete(memory, path)
    if damaged is not None:
        obstore.put(memory, path, damaged)
    reads.clear()
    assert [store.describe(entry), store.describe(entry)] == [right, right]
    assert reads == ["description.json", "manifest.json", "description.json"]


def test_a_manifest_as_published_is_not_checked_again(
    store: ArtifactStore, memory: MemoryStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry, right = undescribed(store, memory, tmp_path)
    monkeypatch.setattr(artifact_store, "LONG", 1)
    monkeypatch.setattr(artifact_store, "parse_manifest", None)
    assert store.describe(entry) == right


def test_a_store_that_cannot_be_written_is_described_all_the_same(
    store: ArtifactStore, memory: MemoryStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry, right = undescribed(store, memory, tmp_path)

    def refuse(*arguments: Any, **options: Any) -> None:
        raise PermissionError(13, "read-only")

    monkeypatch.setattr(obstore, "put", refuse)
    assert store.describe(entry) == right


def test_a_removed_scene_leaves_no_description(store: ArtifactStore, memory: MemoryStore, tmp_path: Path) -> None:
    entry = published(store, tmp_path, 1)
    store.remove_scene("growing")
    assert store.describe(entry) is None
    assert [item["path"] for page in obstore.list(memory, prefix="scenes") for item in page] == []


def test_a_damaged_manifest_is_named(store: ArtifactStore, memory: MemoryStore, tmp_path: Path) -> None:
    entry = published(store, tmp_path, 1)
    obstore.put(memory, "scenes/growing/manifest.json", b"{")
    obstore.delete(memory, "scenes/growing/description.json")
    with pytest.raises(InputError, match="manifest of scene growing: is not JSON"):
        store.describe(entry)


def test_the_file_is_of_one_manifest() -> None:
    assert SceneDescription.unpacked(DESCRIBED.packed("a"), "a") == DESCRIBED
    assert SceneDescription.unpacked(DESCRIBED.packed("a"), "b") is None
