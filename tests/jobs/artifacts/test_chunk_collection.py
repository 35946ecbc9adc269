from __future__ import annotations

import hashlib
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hgs_core.base.errors import InputError
from hgs_core.base.progress import Progress
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.artifacts.chunk_collection import Collection, collect_chunks
from tests.chunks import static_chunk

WriteScene = Callable[..., list[str]]

CHUNKS = [static_chunk(bytes([number])) for number in range(5)]
NAMES = [hashlib.sha256(data).hexdigest() for data in CHUNKS]


@pytest.fixture
def store(tmp_path: Path) -> ArtifactStore:
    return ArtifactStore((tmp_path / "store").as_uri())


def stored(store: ArtifactStore) -> set[str]:
    return {chunk.id for chunk in store.list_chunks()}


def publish(store: ArtifactStore, write_scene: WriteScene, folder: Path, scene: str, chunks: Sequence[int]) -> None:
    write_scene(folder / scene, tuple(CHUNKS[number] for number in chunks))
    store.put_scene(folder / scene, scene)


def test_chunks_of_scenes_that_were_taken_back_are_removed(
    store: ArtifactStore, write_scene: WriteScene, tmp_path: Path
) -> None:
    publish(store, write_scene, tmp_path, "a", [0, 1])
    publish(store, write_scene, tmp_path, "b", [1, 2])
    store.remove_scene("a")
    expected = Collection(1, len(CHUNKS[0]), 1)
    assert collect_chunks(store, delete=False, youngest=0) == expected
    assert stored(store) == {NAMES[0], NAMES[1], NAMES[2]}
    assert collect_chunks(store, delete=True, youngest=0) == expected
    assert stored(store) == {NAMES[1], NAMES[2]}


def test_young_chunks_stay(store: ArtifactStore, write_scene: WriteScene, tmp_path: Path) -> None:
    publish(store, write_scene, tmp_path, "a", [0])
    store.remove_scene("a")
    assert collect_chunks(store, delete=True, youngest=60).chunks == 0


def test_nothing_is_removed_while_a_manifest_is_damaged(
    store: ArtifactStore, write_scene: WriteScene, tmp_path: Path
) -> None:
    publish(store, write_scene, tmp_path, "a", [0])
    publish(store, write_scene, tmp_path, "b", [1])
    store.remove_scene("a")
    (tmp_path / "store" / "scenes" / "b" / "manifest.json").write_bytes(b'{"chunks": [')
    with pytest.raises(InputError, match="scene b: its manifest is damaged"):
        collect_chunks(store, delete=True, youngest=0)
    assert stored(store) == {NAMES[0], NAMES[1]}


ACTIONS = st.one_of(
    st.tuples(st.just("publish"), st.sampled_from("abc"), st.sets(st.integers(0, 4), min_size=1)),
    st.tuples(st.just("remove"), st.sampled_from("abc"), st.just(frozenset[int]())),
    st.tuples(st.just("collect"), st.just(""), st.just(frozenset[int]())),
)


@settings(max_examples=25, deadline=None)
@given(st.lists(ACTIONS, max_size=12))
def test_whatever_is_published_removed_and_collected_every_scene_is_whole(
    actions: list[tuple[str, str, set[int]]],
) -> None:
    from scene_folder import write_scene

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        store = ArtifactStore((folder / "store").as_uri())
        published: dict[str, set[str]] = {}
        for number, (action, scene, chunks) in enumerate(actions):
            if action == "publish" and scene not in published:
                publish(store, write_scene, folder / str(number), scene, sorted(chunks))
                published[scene] = {NAMES[chunk] for chunk in chunks}
            elif action == "remove":
                store.remove_scene(scene)
                published.pop(scene, None)
            elif action == "collect":
                collect_chunks(store, delete=True, youngest=0)
            named = set[str]().union(*published.values())
            assert stored(store) >= named
        collect_chunks(store, delete=True, youngest=0)
        assert stored(store) == named if actions else True


def test_a_scene_that_is_published_while_chunks_are_removed_is_whole(
    store: ArtifactStore, write_scene: WriteScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The worst moment: its chunks are there already and need not be stored, and are just about to be removed."""
    publish(store, write_scene, tmp_path, "a", [0, 1])
    store.remove_scene("a")
    went_on = threading.Event()
    reports: list[int] = []

    def note(progress: Progress) -> None:
        reports.append(progress.done)
        if reports.count(0) > 2:  # it says again and again that it waits
            went_on.set()

    def publish_b() -> None:
        store.put_scene(tmp_path / "a", "b", note)
        went_on.set()

    publisher = threading.Thread(target=publish_b)
    remove = store.remove_chunks

    def remove_later(chunk_ids: Sequence[str]) -> None:
        publisher.start()
        assert went_on.wait(60)
        remove(chunk_ids)

    monkeypatch.setattr(store, "remove_chunks", remove_later)
    assert collect_chunks(store, delete=True, youngest=0).chunks == 2
    publisher.join()
    assert store.manifest("b") is not None
    assert stored(store) == {NAMES[0], NAMES[1]}


KILLED = """
import os, signal, sys
from jobs.artifacts import chunk_collection
from jobs.artifacts.artifact_store import ArtifactStore
chunk_collection._BATCH = 1
store = ArtifactStore(sys.argv[1])
remove = store.remove_chunks
def remove_once(chunk_ids):
    remove(chunk_ids)
    os.kill(os.getpid(), signal.SIGKILL)
store.remove_chunks = remove_once
chunk_collection.collect_chunks(store, delete=True, youngest=0)
"""


def test_a_collector_that_is_killed_half_way_harms_no_scene_and_stands_in_nobodys_way(
    store: ArtifactStore, write_scene: WriteScene, tmp_path: Path
) -> None:
    publish(store, write_scene, tmp_path, "a", [0, 1, 2])
    publish(store, write_scene, tmp_path, "b", [2, 3])
    store.remove_scene("a")
    killed = subprocess.run([sys.executable, "-c", KILLED, (tmp_path / "store").as_uri()], check=False)
    assert killed.returncode == -9
    left = stored(store)
    assert left > {NAMES[2], NAMES[3]}
    assert len(left) == 3
    publish(store, write_scene, tmp_path / "again", "a", [0, 1, 2])  # removed chunks are stored again
    assert stored(store) == set(NAMES[:4])
    assert collect_chunks(store, delete=True, youngest=0).chunks == 0
