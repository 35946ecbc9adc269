"""Scenes on their way into the store."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from obstore.store import MemoryStore
from scene_folder import ONE, TWO, name_of

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress
from hgs_core.codec.format.chunk import pack, unpack
from hgs_core.codec.format.manifest_reading import read_manifest
from hgs_core.codec.format.paging import paged
from jobs.artifacts import artifact_store as artifacts
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.artifacts.publishing_lock import StoreLock
from tests.growing import MOVING, STATIC, write_growing_scene


def poked(chunk: bytes) -> bytes:
    """Return a chunk with a right checksum and a first plane that is no zstd frame."""
    container = unpack(chunk)
    first = container.streams[0]
    damaged = first._replace(planes=(memoryview(b"no frame"), *first.planes[1:]))
    return pack(dataclasses.replace(container, streams=(damaged, *container.streams[1:])))


def test_scene_grows_by_versions_and_never_shrinks(store: ArtifactStore, tmp_path: Path) -> None:
    folder = tmp_path / "growing"
    versions = {}
    for segments in (1, 3, 2):
        versions[segments] = write_growing_scene(folder, segments)
        before = store.scene_entry("growing")
        store.put_scene(folder, "growing")
        assert store.scene_entry("growing") != before or segments == 2
    assert store.manifest("growing") == versions[3]
    assert {chunk.id for chunk in store.list_chunks()} == {name_of(data) for data in (STATIC, *MOVING)}


def test_pages_of_the_manifest_are_kept_ready_beside_it(
    store: ArtifactStore, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(artifacts, "LONG", 1)
    folder = tmp_path / "growing"
    for segments in (1, 2):
        manifest = write_growing_scene(folder, segments)
        store.put_scene(folder, "growing")
        assert store.pages("growing", manifest) == paged(read_manifest(json.loads(manifest)), json.loads(manifest))
        assert store.pages("growing", manifest + b" ") is None
    store.remove_scene("growing")
    assert (store.pages("growing", manifest), store.pages("no/name", manifest)) == (None, None)


def test_growth_reads_no_chunk_again_and_a_damaged_one_changes_nothing(store: ArtifactStore, tmp_path: Path) -> None:
    folder = tmp_path / "growing"
    first = write_growing_scene(folder, 1)
    store.put_scene(folder, "growing")
    shutil.rmtree(folder / "chunks")
    second = write_growing_scene(folder, 2)
    (folder / "chunks" / name_of(STATIC)).unlink()
    (folder / "chunks" / name_of(MOVING[1])).write_bytes(b"damaged")
    with pytest.raises(InputError, match="bytes"):
        store.put_scene(folder, "growing")
    assert store.manifest("growing") == first
    (folder / "chunks" / name_of(MOVING[1])).write_bytes(MOVING[1])
    store.put_scene(folder, "growing")
    assert store.manifest("growing") == second


def test_publishing_again_changes_nothing(
    store: ArtifactStore, scene: Path, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    store.put_scene(scene, "a")
    store.put_scene(scene, "a")
    write_scene(tmp_path / "other", title="Another")
    store.put_scene(tmp_path / "other", "a")
    assert store.manifest("a") == (scene / "manifest.json").read_bytes()


def test_only_what_the_manifest_names_is_published(store: ArtifactStore, scene: Path) -> None:
    (scene / "chunks" / name_of(b"stray")).write_bytes(b"stray")
    store.put_scene(scene, "a")
    assert store.chunk(name_of(b"stray")) is None


def test_a_missing_chunk_is_refused(store: ArtifactStore, scene: Path) -> None:
    path = scene / "chunks" / name_of(TWO)
    path.unlink()
    with pytest.raises(InputError, match=f"{path.name}: cannot be read"):
        store.put_scene(scene, "a")
    assert store.list_scenes() == []


def test_a_missing_thumbnail_is_refused(store: ArtifactStore, scene: Path) -> None:
    (scene / "thumbnail.jpg").unlink()
    with pytest.raises(InputError, match=r"thumbnail\.jpg: cannot be read"):
        store.put_scene(scene, "a")
    assert store.list_scenes() == []


def test_a_manifest_that_is_not_one_is_refused(store: ArtifactStore, scene: Path) -> None:
    (scene / "manifest.json").write_text("{}")
    with pytest.raises(InputError, match=r"manifest\.json"):
        store.put_scene(scene, "a")


def test_a_damaged_chunk_is_refused_and_the_scene_stays_unseen(store: ArtifactStore, scene: Path) -> None:
    path = scene / "chunks" / name_of(TWO)
    path.write_bytes(TWO.replace(b"two", b"tw0"))
    with pytest.raises(InputError, match=f"{path.name}: has the SHA-256"):
        store.put_scene(scene, "a")
    assert store.list_scenes() == []
    assert store.chunk(path.name) is None


def test_a_chunk_that_cannot_be_decoded_is_refused_with_the_cure(
    store: ArtifactStore, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    broken = poked(TWO)
    name = write_scene(tmp_path / "scene", (ONE, broken))[1]
    with pytest.raises(InputError, match=rf"chunks/{name}: cannot be decoded .*; encode the scene again: hgs encode"):
        store.put_scene(tmp_path / "scene", "a")
    assert store.list_scenes() == []
    assert store.chunk(name) is None


def test_every_chunk_is_read_once(store: ArtifactStore, scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []
    read_bytes = Path.read_bytes

    def counted(path: Path) -> bytes:
        read.append(path.name)
        return read_bytes(path)

    monkeypatch.setattr(Path, "read_bytes", counted)
    store.put_scene(scene, "a")
    assert sorted(name for name in read if len(name) == 64) == sorted(map(name_of, (ONE, TWO)))


def test_a_folder_without_a_manifest_is_refused(store: ArtifactStore, scene: Path) -> None:
    (scene / "manifest.json").unlink()
    with pytest.raises(InputError, match=r"manifest\.json: cannot be read"):
        store.put_scene(scene, "a")


def test_the_manifest_is_the_last_thing_published(store: ArtifactStore, scene: Path) -> None:
    seen: list[tuple[int, bool]] = []

    def progress(update: Progress) -> None:
        seen.append((update.done, store.manifest("a") is not None))
        assert (update.stage, update.total) == ("publish", 3)

    store.put_scene(scene, "a", progress)
    assert seen == [(0, False), (1, False), (2, False), (3, True)]


class LostLock(StoreLock):
    """A lock that is lost while chunks are stored."""

    @contextlib.contextmanager
    def _held(self, waiting: Callable[[], object], *, alone: bool) -> Iterator[Callable[[], object]]:
        def require() -> None:
            raise ConnectionResetError

        yield require


def test_a_publisher_that_lost_the_lock_writes_no_manifest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write_scene: Callable[..., list[str]]
) -> None:
    monkeypatch.setattr(artifacts, "open_object_store", lambda url, once: MemoryStore())
    store = ArtifactStore("s3://bucket", LostLock())
    write_scene(tmp_path / "scene")
    with pytest.raises(ConnectionResetError):
        store.put_scene(tmp_path / "scene", "a")
    assert store.manifest("a") is None
