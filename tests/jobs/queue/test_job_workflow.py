"""The parts of the workflow by themselves, on a database and a stand-in for the stages' processes.

The whole of it, under DBOS, is tested in test_worker.py, test_kill.py and test_outages.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from dbos import DBOSClient

from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.database import open_client
from jobs.home.home import Home
from jobs.home.passing_faults import Cause
from jobs.process.stage_outcome import Waits
from jobs.process.stage_runner import StageRunner
from jobs.queue import job_workflow as workflows
from jobs.queue.job_workflow import TrainingWorkflow
from jobs.records.job import Job, JobState
from jobs.records.job_table import JobTable
from jobs.runs.readiness import Surroundings

AWAY = Waits("the store is away", Cause.STORE)


@pytest.fixture
def queue(home: Home, home_engine: sa.Engine, surroundings: Surroundings) -> Iterator[DBOSClient]:
    client = open_client(home, home_engine)
    yield client
    client.destroy()


@pytest.fixture
def workflow(
    home: Home, home_engine: sa.Engine, surroundings: Surroundings, queue: DBOSClient, table: JobTable
) -> TrainingWorkflow:
    return TrainingWorkflow(home, surroundings, home_engine, queue, StageRunner(home))


def row(table: JobTable) -> Job:
    job = table.get("a")
    assert job is not None
    return job


class TestPuttingOff:
    """The attempts queued after a passing fault, and their times."""

    @pytest.fixture(autouse=True)
    def queued(self, monkeypatch: pytest.MonkeyPatch) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = []

        def enqueue(queue: object, connection: object, job_id: str, attempt: int, **options: Any) -> None:
            found.append({"attempt": attempt} | options)

        monkeypatch.setattr(workflows, "enqueue", enqueue)
        return found

    def test_the_waits_become_longer_but_not_too_long(
        self, workflow: TrainingWorkflow, queued: list[dict[str, Any]]
    ) -> None:
        waits = 0
        for attempt in range(1, 30):
            workflow._put_off("a", attempt, AWAY, waits, "encode")
            waits = queued[-1]["waits"]
        assert [one["delay"] for one in queued[:13]] == [5, 10, 20, 40, 80, 160, 320, 640, 1280, 2560, 5120, 7200, 7200]
        assert queued[-1] == queued[-2] | {"attempt": 30}  # and the count stops where 2.0**waits is far from too large

    def test_the_next_attempt_begins_with_the_stage_that_failed(
        self, workflow: TrainingWorkflow, table: JobTable, queued: list[dict[str, Any]]
    ) -> None:
        workflow._put_off("a", 1, AWAY, 2, "publish")
        assert queued == [{"attempt": 2, "delay": 20, "waits": 3, "first": "publish", "time_limit": 0}]
        job = row(table)
        assert (job.state, job.attempt, job.waiting, job.cause) == (JobState.WAITING, 2, "the store is away", "store")

    def test_a_job_that_was_cancelled_is_not_queued(
        self, workflow: TrainingWorkflow, table: JobTable, queued: list[dict[str, Any]]
    ) -> None:
        table.cancel("a", 1)
        workflow._put_off("a", 1, AWAY, 0, "train")
        assert queued == []
        assert row(table).state is JobState.CANCELLED


class TestFinish:
    """The end of a job after publication."""

    @pytest.fixture(autouse=True)
    def _published(self, home: Home, tmp_path: Path, write_scene: Callable[..., list[str]]) -> None:
        write_scene(tmp_path / "scene")
        ArtifactStore(home.store_url).put_scene(tmp_path / "scene", "a")

    def scenes(self, home: Home) -> list[str]:
        return [scene.id for scene in ArtifactStore(home.store_url).list_scenes()]

    def test_it_has_succeeded_and_its_scene_is_named_as_it_is(
        self, workflow: TrainingWorkflow, table: JobTable, home: Home
    ) -> None:
        workflow._finish("a", 1)
        assert (row(table).state, row(table).scene_id) == (JobState.SUCCEEDED, "a")
        assert self.scenes(home) == ["a"]

    def test_what_a_cancelled_job_made_is_not_shown(
        self, workflow: TrainingWorkflow, table: JobTable, home: Home
    ) -> None:
        table.cancel("a", 1)
        workflow._finish("a", 1)
        assert row(table).state is JobState.CANCELLED
        assert self.scenes(home) == []

    def test_the_scene_of_a_job_that_a_later_attempt_works_on_stays(
        self, workflow: TrainingWorkflow, table: JobTable, home_engine: sa.Engine, home: Home
    ) -> None:
        with home_engine.begin() as connection:
            table.put_off(connection, "a", 1, "its worker was slow")
        workflow._finish("a", 1)
        assert row(table).state is JobState.WAITING
        assert self.scenes(home) == ["a"]

    @pytest.mark.parametrize("after", ["cancelled", "retried", "succeeded"])
    def test_a_cancelled_publication_is_taken_back_where_nothing_has_happened_since(
        self, workflow: TrainingWorkflow, table: JobTable, home_engine: sa.Engine, home: Home, after: str
    ) -> None:
        if after == "succeeded":
            table.succeed("a", 1, "a")
        else:
            table.cancel("a", 1)
        if after == "retried":
            with home_engine.begin() as connection:
                table.requeue(connection, "a", 1)
        workflow._withdraw("a", 1)
        assert self.scenes(home) == ([] if after == "cancelled" else ["a"])
