from __future__ import annotations

from pathlib import Path

import pytest

from hgs_core.codec import load_manifest
from hgs_core.codec.format.scene_folder import checked_chunks
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.artifacts.scene_copy import copy_scene


def test_a_copy_is_a_whole_scene_folder_under_its_own_title(store: ArtifactStore, scene: Path, tmp_path: Path) -> None:
    store.put_scene(scene, "studio")
    copy_scene(store, "studio", tmp_path / "copy", "Another")
    before, after = load_manifest(scene), load_manifest(tmp_path / "copy")
    assert (after.title, after.thumbnail, after.static) == ("Another", False, before.static)
    assert len(list(checked_chunks(tmp_path / "copy", after))) == 2


def test_a_scene_that_is_not_there_has_no_copy(store: ArtifactStore, tmp_path: Path) -> None:
    with pytest.raises(KeyError, match="studio"):
        copy_scene(store, "studio", tmp_path / "copy", "Another")


def test_a_scene_that_is_being_deleted_leaves_no_manifest(store: ArtifactStore, scene: Path, tmp_path: Path) -> None:
    store.put_scene(scene, "studio")
    store.remove_chunks([load_manifest(scene).static[1].id])
    with pytest.raises(KeyError, match="studio"):
        copy_scene(store, "studio", tmp_path / "copy", "Another")
    assert not (tmp_path / "copy" / "manifest.json").exists()
