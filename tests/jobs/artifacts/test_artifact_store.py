from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from scene_folder import ONE, TWO, name_of

from hgs_core.base.errors import InputError
from jobs.artifacts.artifact_store import ArtifactStore


def test_a_published_scene_can_be_read(store: ArtifactStore, scene: Path) -> None:
    store.put_scene(scene, "studio-1")
    assert store.manifest("studio-1") == (scene / "manifest.json").read_bytes()
    assert store.thumbnail("studio-1") == b"a picture"
    assert [store.chunk(name_of(data)) for data in (ONE, TWO)] == [ONE, TWO]


def test_scenes_are_listed_newest_first(store: ArtifactStore, scene: Path, tmp_path: Path) -> None:
    assert store.list_scenes() == []
    store.put_scene(scene, "b")
    store.put_scene(scene, "a")
    (tmp_path / "store" / "scenes" / "c").mkdir()  # not complete: no manifest
    entries = store.list_scenes()
    assert sorted(entry.id for entry in entries) == ["a", "b"]
    assert entries[0].published >= entries[1].published
    assert abs(datetime.now(UTC) - entries[0].published) < timedelta(minutes=10)


def test_one_scene_is_looked_up_as_it_is_listed(store: ArtifactStore, scene: Path) -> None:
    store.put_scene(scene, "a")
    assert [store.scene_entry("a")] == store.list_scenes()
    for unknown in ("b", "../a", "A", "a" * 65):
        assert store.scene_entry(unknown) is None


def test_a_scene_published_anew_has_another_version(
    store: ArtifactStore, scene: Path, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    store.put_scene(scene, "a")
    before = store.scene_entry("a")
    store.remove_scene("a")
    write_scene(tmp_path / "other", title="Another")
    store.put_scene(tmp_path / "other", "a")
    after = store.scene_entry("a")
    assert before is not None
    assert after is not None
    assert before.version != after.version


@pytest.mark.parametrize("scene_id", ["", "../a", "a/b", "A", ".a", "a" * 65, "a\n", "é"])
def test_a_malformed_scene_id_is_refused_and_unknown(store: ArtifactStore, scene: Path, scene_id: str) -> None:
    with pytest.raises(InputError, match="scene id"):
        store.put_scene(scene, scene_id)
    assert store.manifest(scene_id) is None
    assert store.thumbnail(scene_id) is None
    store.remove_scene(scene_id)


@pytest.mark.parametrize("chunk_id", ["", "0" * 63, "0" * 64, "G" * 64, "../scenes/a/manifest.json", "0" * 64 + "\n"])
def test_an_unknown_chunk_is_none(store: ArtifactStore, scene: Path, chunk_id: str) -> None:
    store.put_scene(scene, "a")
    assert store.chunk(chunk_id) is None


def test_a_removed_scene_is_gone_and_its_chunks_stay(store: ArtifactStore, scene: Path) -> None:
    store.put_scene(scene, "a")
    store.remove_scene("a")
    store.remove_scene("a")
    assert store.list_scenes() == []
    assert store.thumbnail("a") is None
    assert store.chunk(name_of(ONE)) == ONE


def test_a_renamed_scene_keeps_its_manifest(store: ArtifactStore, scene: Path) -> None:
    store.put_scene(scene, "a")
    before = store.scene_entry("a")
    assert before is not None
    assert (store.title("a"), before.renamed) == (None, "")
    store.rename_scene("a", "Zoë's studio")
    after = store.scene_entry("a")
    assert after is not None
    assert store.title("a") == "Zoë's studio"
    assert (after.version, store.manifest("a")) == (before.version, (scene / "manifest.json").read_bytes())
    assert after.renamed
    assert [after] == store.list_scenes()


def test_a_scene_that_is_removed_and_published_anew_has_its_first_title(store: ArtifactStore, scene: Path) -> None:
    store.put_scene(scene, "a")
    store.rename_scene("a", "Another")
    store.remove_scene("a")
    store.put_scene(scene, "a")
    assert store.title("a") is None


def test_a_scene_that_is_not_there_gets_no_title(store: ArtifactStore) -> None:
    for unknown in ("b", "../b"):
        store.rename_scene(unknown, "Another")
        assert store.title(unknown) is None
    assert store.list_scenes() == []


def test_a_store_on_a_path_with_spaces_and_umlauts(tmp_path: Path, scene: Path) -> None:
    folder = tmp_path / "my störe"
    ArtifactStore(folder.as_uri()).put_scene(scene, "a")
    assert (folder / "scenes" / "a" / "manifest.json").is_file()


def test_an_s3_url_opens_without_a_connection() -> None:
    ArtifactStore("s3://bucket/prefix")
