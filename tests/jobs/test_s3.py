"""The artifact store on an object store."""

from __future__ import annotations

import dataclasses
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from s3_server import S3Server, running_s3_server

from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.records.job import Job, JobState
from tests.chunks import static_chunk

CHUNK = static_chunk(b"a chunk")


@pytest.fixture
def store(s3_url: str) -> ArtifactStore:
    return ArtifactStore(s3_url)


def test_a_published_scene_can_be_read_and_removed(
    store: ArtifactStore, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    (chunk,) = write_scene(tmp_path / "scene", (CHUNK,))
    manifest = (tmp_path / "scene" / "manifest.json").read_bytes()
    store.put_scene(tmp_path / "scene", "a")
    assert [entry.id for entry in store.list_scenes()] == ["a"]
    assert (store.manifest("a"), store.thumbnail("a"), store.chunk(chunk)) == (manifest, b"a picture", CHUNK)
    store.remove_scene("a")
    store.remove_scene("a")
    assert store.list_scenes() == []
    assert store.chunk(chunk) == CHUNK


def test_a_scene_looked_up_has_the_version_of_the_listed_one(
    store: ArtifactStore, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    write_scene(tmp_path / "scene")
    store.put_scene(tmp_path / "scene", "a")
    entry = store.scene_entry("a")
    assert entry is not None
    assert [(entry.id, entry.version)] == [(one.id, one.version) for one in store.list_scenes()]
    assert store.scene_entry("b") is None


def test_nothing_published_is_overwritten(
    store: ArtifactStore, tmp_path: Path, write_scene: Callable[..., list[str]]
) -> None:
    write_scene(tmp_path / "first", title="First")
    write_scene(tmp_path / "second", title="Second")
    store.put_scene(tmp_path / "first", "a")
    store.put_scene(tmp_path / "second", "a")
    assert store.manifest("a") == (tmp_path / "first" / "manifest.json").read_bytes()


def test_unknown_names_are_none(store: ArtifactStore) -> None:
    assert store.manifest("nobody") is None
    assert store.thumbnail("nobody") is None
    assert store.chunk("0" * 64) is None


class TestOutage:
    """The store refuses connections for a while."""

    @pytest.fixture
    def server(self, monkeypatch: pytest.MonkeyPatch) -> Iterator[S3Server]:
        with running_s3_server() as server:
            for name, value in server.settings.items():
                monkeypatch.setenv(name, value)
            yield server

    @pytest.fixture
    def home(self, tmp_path: Path, pipeline: str, server: S3Server) -> Home:
        return dataclasses.replace(Home.at(tmp_path / "home"), pipeline=pipeline, store_url="s3://bucket/hgs")

    @pytest.mark.slow
    def test_the_job_waits_and_is_published_afterwards(
        self,
        server: S3Server,
        client: JobClient,
        submit: Callable[..., str],
        worker: Callable[[], subprocess.Popen[bytes]],
        wait_for: Callable[[str, Callable[[Job], bool], str], Job],
    ) -> None:
        worker()
        job_id = submit(iterations=50)
        wait_for(job_id, lambda job: job.stage == "train", "training")
        server.stop()
        job = wait_for(job_id, lambda job: bool(job.waiting) or job.state.finished, "the fault")
        assert job.state is JobState.WAITING
        assert job.waiting.startswith("the store fails: Generic S3 error: Error performing GET ")
        assert "RetryError" not in job.waiting  # none of the pages that the library adds
        assert job.cause == "store"
        another = submit()
        server.start()
        assert wait_for(job_id, lambda job: job.state.finished, "the end of the job").state is JobState.SUCCEEDED
        assert wait_for(another, lambda job: job.state.finished, "the end of the other").state is JobState.SUCCEEDED
        assert {scene.id for scene in ArtifactStore(client.home.store_url).list_scenes()} == {job_id, another}
