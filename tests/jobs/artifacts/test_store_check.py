from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import obstore
import pytest

from jobs.artifacts.artifact_store import ArtifactStore
from jobs.artifacts.store_check import check_store
from jobs.home.object_store import open_object_store
from tests.chunks import static_chunk

ONE, TWO, THREE = (static_chunk(name) for name in (b"one", b"two", b"three"))


@pytest.fixture(params=["folder", "S3"])
def url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    return (tmp_path / "store").as_uri() if request.param == "folder" else str(request.getfixturevalue("s3_url"))


@pytest.fixture
def chunks(url: str, tmp_path: Path, write_scene: Callable[..., list[str]]) -> list[str]:
    """Two published scenes, which share the second of these chunks."""
    store = ArtifactStore(url)
    named = []
    for scene, data in (("a", (ONE, TWO)), ("b", (TWO, THREE))):
        named += write_scene(tmp_path / scene, data)
        store.put_scene(tmp_path / scene, scene)
    return list(dict.fromkeys(named))


def test_a_sound_store(url: str, chunks: list[str]) -> None:
    seen: list[tuple[int, int]] = []
    found = check_store(ArtifactStore(url), lambda done, total: seen.append((done, total)))
    assert (found.scenes, found.chunks, found.bytes) == (2, 3, len(ONE) + len(TWO) + len(THREE))
    assert found.sound
    assert seen == [(1, 3), (2, 3), (3, 3)]


def test_what_is_missing_or_damaged_is_named_with_its_scenes(url: str, chunks: list[str]) -> None:
    bucket = open_object_store(url)
    obstore.delete(bucket, f"chunks/{chunks[1]}")
    obstore.put(bucket, f"chunks/{chunks[2]}", THREE[:-1])
    obstore.put(bucket, f"chunks/{'0' * 64}", b"nobody names it")
    found = check_store(ArtifactStore(url))
    assert not found.sound
    faults = {fault.chunk: (fault.problem, set(fault.scenes)) for fault in found.faults}
    assert faults == {chunks[1]: ("missing", {"a", "b"}), chunks[2]: ("damaged", {"b"})}
    assert len(list(ArtifactStore(url).list_chunks())) == 3  # nothing is changed


@pytest.mark.parametrize("text", [b"", b"{", b"[]", b'{"format": 1}', b"[" * 100_000])
def test_a_damaged_manifest_is_named(url: str, chunks: list[str], text: bytes) -> None:
    obstore.put(open_object_store(url), "scenes/a/manifest.json", text)
    found = check_store(ArtifactStore(url))
    assert (found.unreadable, found.chunks) == (("a",), 2)
    assert not found.sound


def test_a_scene_that_is_removed_meanwhile_does_not_count(url: str, chunks: list[str]) -> None:
    store = ArtifactStore(url)
    obstore.delete(open_object_store(url), f"chunks/{chunks[0]}")
    assert check_store(store, lambda done, total: store.remove_scene("a")).faults == ()
