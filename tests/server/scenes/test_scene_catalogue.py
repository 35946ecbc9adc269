"""The list of scenes on a real store: counted listings and reads of each look."""

from __future__ import annotations

import asyncio
import json
import logging
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import pytest

from hgs_core.codec.format.paging import PagedScene
from jobs.artifacts import artifact_store
from jobs.artifacts.artifact_store import ArtifactStore, SceneEntry
from jobs.artifacts.scene_description import SceneDescription
from jobs.records.job import Job
from server.http.problems import ProblemError
from server.scenes import scene_catalogue as module
from server.scenes.scene_catalogue import SceneCatalogue
from server.scenes.scene_index import SceneIndex, read_scene
from tests.growing import write_growing_scene


class CountingStore(ArtifactStore):
    """A store that notes its requests."""

    def __init__(self, folder: Path) -> None:
        self.uri = folder.as_uri()
        super().__init__(self.uri)
        self.listings = 0
        self.reads: list[str] = []
        self.titles: list[str] = []
        self.unreadable: set[str] = set()

    def put_scene(self, folder: Path, scene_id: str) -> None:
        """Uncounted: publishing lists the store."""
        ArtifactStore(self.uri).put_scene(folder, scene_id)

    def list_scenes(self) -> list[SceneEntry]:
        self.listings += 1
        return super().list_scenes()

    def title(self, scene_id: str) -> str | None:
        self.titles.append(scene_id)
        return super().title(scene_id)

    def manifest(self, scene_id: str) -> bytes | None:
        self.reads.append(scene_id)
        return super().manifest(scene_id)

    def describe(self, entry: SceneEntry) -> SceneDescription | None:
        self.reads.append(entry.id)
        if entry.id in self.unreadable:
            raise PermissionError(13, "permission denied")
        return super().describe(entry)


class NoJobs:
    """A queue without jobs that counts the questions; `titles` are of jobs that made scenes."""

    def __init__(self) -> None:
        self.questions = 0
        self.titles: dict[str, str] = {}

    def many(self, job_ids: Collection[str]) -> dict[str, Job]:
        self.questions += 1
        return {name: Job(name, title, "", {}) for name, title in self.titles.items() if name in job_ids}


@pytest.fixture
def store(tmp_path: Path, scene_folder: Path) -> CountingStore:
    store = CountingStore(tmp_path / "store")
    for number in range(5):
        store.put_scene(scene_folder / "scene", f"scene-{number}")
    return store


@pytest.fixture
def jobs() -> NoJobs:
    return NoJobs()


@pytest.fixture
def catalogue(store: CountingStore, jobs: NoJobs) -> SceneCatalogue:
    return SceneCatalogue(store, jobs)  # type: ignore[arg-type]


def listed(catalogue: SceneCatalogue) -> list[str]:
    return sorted(scene["id"] for scene in asyncio.run(catalogue.scenes()))


ALL = [f"scene-{number}" for number in range(5)]


def test_descriptions_are_read_once_and_a_look_costs_one_listing(
    catalogue: SceneCatalogue, store: CountingStore, jobs: NoJobs
) -> None:
    for looks in (1, 2, 3):
        assert listed(catalogue) == ALL
        assert (store.listings, sorted(store.reads), jobs.questions) == (looks, ALL, 1)


def test_a_new_title_costs_one_read_of_the_title_alone(catalogue: SceneCatalogue, store: CountingStore) -> None:
    listed(catalogue)
    for title in ("First", "Second"):
        store.reads, store.titles = [], []
        store.rename_scene("scene-3", title)
        scenes = [asyncio.run(catalogue.scenes()) for _ in range(3)][-1]
        assert [scene["title"] for scene in scenes if scene["id"] == "scene-3"] == [title]
        assert catalogue.describe("scene-3")["title"] == title
        assert (store.reads, store.titles) == ([], ["scene-3"])


def test_one_scene_is_described_without_a_look_at_the_others(catalogue: SceneCatalogue, store: CountingStore) -> None:
    for _ in range(3):
        assert catalogue.describe("scene-3")["id"] == "scene-3"
    assert (store.listings, store.reads) == (0, ["scene-3"])
    assert catalogue.describe("scene-3") in asyncio.run(catalogue.scenes())
    assert sorted(store.reads) == ALL


def test_scenes_that_are_taken_back_vanish_and_new_ones_appear(
    catalogue: SceneCatalogue, store: CountingStore, scene_folder: Path
) -> None:
    listed(catalogue)
    store.remove_scene("scene-2")
    store.put_scene(scene_folder / "scene", "scene-9")
    assert listed(catalogue) == [*ALL[:2], *ALL[3:], "scene-9"]
    assert store.reads[5:] == ["scene-9"]
    for ask in (catalogue.describe, catalogue.scene):
        with pytest.raises(ProblemError, match="scene-2: no such scene"):
            ask("scene-2")


def test_a_scene_published_anew_under_its_id_is_read_again(
    catalogue: SceneCatalogue, store: CountingStore, scene_folder: Path
) -> None:
    listed(catalogue)
    old = catalogue.scene("scene-1").document
    assert old
    store.remove_scene("scene-1")
    path = scene_folder / "scene" / "manifest.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"title": "Another"}))
    store.put_scene(scene_folder / "scene", "scene-1")
    assert {s["id"]: s["title"] for s in asyncio.run(catalogue.scenes())}["scene-1"] == "Another"
    assert catalogue.describe("scene-1")["title"] == "Another"
    assert catalogue.scene("scene-1").document == path.read_bytes() != old


@pytest.mark.parametrize("damaged", [b"", b"{}", b"\xff", b"[" * 100_000, b'{"format": ' + b"9" * 5000 + b"}"])
def test_a_damaged_scene_is_left_out_and_read_once(
    catalogue: SceneCatalogue, tmp_path: Path, store: CountingStore, damaged: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "store" / "scenes" / "scene-2" / "manifest.json").write_bytes(damaged)
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            assert listed(catalogue) == [*ALL[:2], *ALL[3:]]
    assert sorted(store.reads) == ALL
    assert len([record for record in caplog.records if "scene-2 is left out" in record.message]) == 1
    for ask in (catalogue.describe, catalogue.scene):
        with pytest.raises(ProblemError) as refused:
            ask("scene-2")
        assert refused.value.status == 500


def test_a_scene_that_cannot_be_read_now_comes_back(
    catalogue: SceneCatalogue, store: CountingStore, caplog: pytest.LogCaptureFixture
) -> None:
    store.unreadable = {"scene-0"}
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            assert listed(catalogue) == ALL[1:]
    assert len([record for record in caplog.records if "scene-0" in record.message]) == 1
    store.unreadable = set()
    assert listed(catalogue) == ALL


def test_callers_at_once_share_looks(catalogue: SceneCatalogue, store: CountingStore) -> None:
    async def scenario() -> Sequence[Any]:
        return await asyncio.gather(*(catalogue.scenes() for _ in range(50)))

    assert {len(scenes) for scenes in asyncio.run(scenario())} == {5}
    assert store.listings == 1


def test_who_asks_after_a_look_has_begun_sees_what_was_published_since(
    catalogue: SceneCatalogue, store: CountingStore, scene_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def scenario() -> tuple[int, int]:
        begun, go_on = asyncio.Event(), asyncio.Event()
        thread = module.run_in_threadpool

        async def held(look: Any) -> Any:
            scenes = await thread(look)
            begun.set()
            await go_on.wait()
            return scenes

        monkeypatch.setattr(module, "run_in_threadpool", held)
        first = asyncio.create_task(catalogue.scenes())
        await begun.wait()
        store.put_scene(scene_folder / "scene", "scene-9")
        second = asyncio.create_task(catalogue.scenes())
        await asyncio.sleep(0)
        go_on.set()
        return len(await first), len(await second)

    assert asyncio.run(scenario()) == (5, 6)


def test_a_caller_that_leaves_does_not_take_the_look_from_the_others(catalogue: SceneCatalogue) -> None:
    async def scenario() -> int:
        leaving, staying = (asyncio.create_task(catalogue.scenes()) for _ in range(2))
        await asyncio.sleep(0)
        leaving.cancel()
        return len(await staying)

    assert asyncio.run(scenario()) == 5


def test_titles_of_jobs_go_before_those_of_manifests(catalogue: SceneCatalogue, jobs: NoJobs) -> None:
    jobs.titles = {"scene-1": "My studio"}
    titles = {scene["id"]: scene["title"] for scene in asyncio.run(catalogue.scenes())}
    assert (titles["scene-0"], titles["scene-1"]) == ("Studio", "My studio")


def test_a_title_that_no_answer_could_hold_is_shown_with_a_replacement(
    catalogue: SceneCatalogue, store: CountingStore, scene_folder: Path
) -> None:
    path = scene_folder / "scene" / "manifest.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | {"title": "half \ud800"}))
    store.put_scene(scene_folder / "scene", "odd")
    assert catalogue.describe("odd")["title"] == "half \ufffd"


def _index_memory(store: CountingStore) -> int:
    return read_scene("scene-0", store.manifest("scene-0") or b"").memory


def test_an_index_larger_than_the_cache_is_kept_while_it_is_the_last(store: CountingStore, jobs: NoJobs) -> None:
    catalogue = SceneCatalogue(store, jobs, capacity=1)  # type: ignore[arg-type]
    for scene_id in ("scene-0", "scene-0", "scene-1", "scene-0"):
        catalogue.scene(scene_id)
    assert store.reads == ["scene-0", "scene-1", "scene-0"]


def test_indices_are_kept_for_the_scenes_watched_last(store: CountingStore, jobs: NoJobs) -> None:
    catalogue = SceneCatalogue(store, jobs, capacity=int(2.5 * _index_memory(store)))  # type: ignore[arg-type]
    store.reads.clear()
    for scene_id in ("scene-0", "scene-1", "scene-0", "scene-2", "scene-0", "scene-1"):
        catalogue.scene(scene_id)
    assert store.reads == ["scene-0", "scene-1", "scene-2", "scene-1"]


def test_pages_that_publishing_left_save_the_reading_of_a_long_manifest(
    catalogue: SceneCatalogue, store: CountingStore, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    write_growing_scene(tmp_path / "growing", 2)
    store.put_scene(tmp_path / "growing", "growing")
    asked: list[PagedScene | None] = []

    def read(scene_id: str, manifest: bytes, ready: PagedScene | None = None) -> SceneIndex:
        asked.append(ready)
        return read_scene(scene_id, manifest, ready)

    monkeypatch.setattr(module, "read_scene", read)
    monkeypatch.setattr(artifact_store, "LONG", 1000)
    index = catalogue.scene("growing")
    assert [None if ready is None else ready.pages.keys() for ready in asked] == [
        {name.hex() for name in index.page_bytes}
    ]
    monkeypatch.setattr(artifact_store, "LONG", 1 << 20)
    assert SceneCatalogue(store, NoJobs()).scene("growing") == index  # type: ignore[arg-type]
    assert asked[1] is None
