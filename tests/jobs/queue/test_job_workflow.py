"""The parts of the workflow by themselves, on a database and a stand-in for the stages' processes.

The whole of it, under DBOS, is tested in test_worker.py, test_kill.py and test_outages.py.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import os
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from pathlib import Path
from typing import Any, cast

import pytest
import sqlalchemy as sa
from dbos import DBOSClient

from hgs_core.base.progress import Progress
from jobs.artifacts.artifact_store import ArtifactStore
from jobs.home.database import create_engine, open_client, prepare_database
from jobs.home.home import Home
from jobs.home.passing_faults import Cause
from jobs.process.stage_outcome import StageOutcome
from jobs.process.stage_runner import StageRunner
from jobs.queue import job_workflow as workflows
from jobs.queue.job_workflow import TrainingWorkflow
from jobs.records.job import Job, JobState
from jobs.records.job_table import JobTable, metadata
from jobs.runs.progress_log import read_course
from jobs.runs.readiness import Missing, Surroundings
from jobs.runs.run_saving import RunSaving

AWAY = StageOutcome(waiting="the store is away", cause="store")

OnProgress = Callable[[Progress], Awaitable[None]]


class FakeStages:
    """Ends every stage with the next of the given outcomes; one that is an exception is raised."""

    def __init__(self) -> None:
        self.outcomes: list[StageOutcome | OSError] = []
        self.reports: list[Progress] = []
        self.on_report: Callable[[], object] = lambda: None
        self.started: list[tuple[str, str, Path]] = []

    async def run(self, workflow: str, stage: str, run: Path, on_progress: OnProgress) -> StageOutcome:
        self.started.append((workflow, stage, run))
        for report in self.reports:
            await on_progress(report)
            self.on_report()
        outcome = self.outcomes.pop(0)
        if isinstance(outcome, OSError):
            raise outcome
        return outcome


@pytest.fixture
def stages() -> FakeStages:
    return FakeStages()


@pytest.fixture
def engine(home: Home) -> Iterator[sa.Engine]:
    engine = create_engine(home)
    yield engine
    engine.dispose()


@pytest.fixture
def queue(home: Home, engine: sa.Engine) -> Iterator[DBOSClient]:
    prepare_database(home, engine, metadata)
    client = open_client(home, engine)
    yield client
    client.destroy()


@pytest.fixture
def table(engine: sa.Engine, queue: DBOSClient, home: Home, tmp_path: Path) -> JobTable:
    """The table of jobs, with the job "a", which runs."""
    table = JobTable(engine)
    (tmp_path / "capture").mkdir()
    (tmp_path / "capture" / "frame.jpg").touch()
    home.run("a").mkdir(parents=True)
    with engine.begin() as connection:
        table.insert(connection, Job(id="a", title="A", capture=str(tmp_path / "capture"), config={}))
    table.start("a", 1)
    return table


@pytest.fixture
def workflow(home: Home, engine: sa.Engine, queue: DBOSClient, table: JobTable, stages: FakeStages) -> TrainingWorkflow:
    surroundings = Surroundings(home, prepare_database(home, engine, metadata))
    return TrainingWorkflow(home, surroundings, engine, queue, cast(StageRunner, stages))


def row(table: JobTable) -> Job:
    job = table.get("a")
    assert job is not None
    return job


def run_stage(workflow: TrainingWorkflow, stage: str = "train") -> StageOutcome:
    return asyncio.run(workflow._run_stage(stage, "a", 1))


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


class TestStages:
    """One stage of a job."""

    def test_a_stage_runs_in_the_job_s_folder_and_its_reports_are_kept(
        self, workflow: TrainingWorkflow, table: JobTable, stages: FakeStages, home: Home
    ) -> None:
        stages.outcomes = [StageOutcome()]
        stages.reports = [Progress("train", 5, 10, {"loss": 0.25})]
        assert run_stage(workflow) == StageOutcome()
        assert stages.started == [("a:1", "train", home.run("a"))]
        job = row(table)
        assert (job.stage, job.done, job.total) == ("train", 5, 10)
        assert len(read_course(home.run("a"))) == 1  # not the word that the stage begins

    def test_a_stage_that_a_signal_ended_is_started_three_times(
        self, workflow: TrainingWorkflow, stages: FakeStages
    ) -> None:
        killed = StageOutcome("ended by SIGKILL", killed=True)
        stages.outcomes = [killed, killed, killed, StageOutcome()]
        assert run_stage(workflow) == killed
        assert len(stages.started) == 3

    def test_a_stage_that_comes_further_each_time_is_started_again_and_again(
        self, workflow: TrainingWorkflow, stages: FakeStages
    ) -> None:
        stages.outcomes = [*[StageOutcome("ended by SIGKILL", killed=True)] * 8, StageOutcome()]
        stages.reports = [Progress("train", 0, 100)]
        stages.on_report = lambda: stages.reports.__setitem__(0, Progress("train", len(stages.started), 100))
        assert run_stage(workflow) == StageOutcome()
        assert len(stages.started) == 9

    def test_a_stage_that_failed_by_itself_is_not_started_again(
        self, workflow: TrainingWorkflow, stages: FakeStages
    ) -> None:
        stages.outcomes = [StageOutcome("the loss is not a number"), StageOutcome()]
        assert run_stage(workflow) == StageOutcome("the loss is not a number")
        assert len(stages.started) == 1

    def test_a_full_disk_at_the_start_is_waited_for(self, workflow: TrainingWorkflow, stages: FakeStages) -> None:
        stages.outcomes = [OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), "/runs/a/stage.log")]
        assert run_stage(workflow).waiting == "/runs/a/stage.log: No space left on device"

    def test_a_stage_does_not_begin_without_its_capture(
        self, workflow: TrainingWorkflow, stages: FakeStages, tmp_path: Path
    ) -> None:
        (tmp_path / "capture" / "frame.jpg").unlink()
        outcome = run_stage(workflow, "encode")
        assert outcome.waiting.endswith("the capture's folder is empty; is it mounted?")
        assert (outcome.error, outcome.cause) == ("", "capture")
        assert stages.started == []

    def test_publication_needs_no_capture(self, workflow: TrainingWorkflow, stages: FakeStages, tmp_path: Path) -> None:
        (tmp_path / "capture" / "frame.jpg").unlink()
        stages.outcomes = [StageOutcome()]
        assert run_stage(workflow, "publish") == StageOutcome()

    def test_a_failure_is_not_believed_while_the_capture_cannot_be_seen(
        self, workflow: TrainingWorkflow, stages: FakeStages, tmp_path: Path
    ) -> None:
        stages.outcomes, stages.reports = [StageOutcome("frame 0 is missing")], [Progress("train", 1, 2)]
        stages.on_report = (tmp_path / "capture" / "frame.jpg").unlink
        outcome = run_stage(workflow)
        assert outcome.waiting.endswith("the capture's folder is empty; is it mounted?")
        assert outcome.cause == "capture"

    def test_a_store_that_is_seen_to_be_away_is_the_cause(
        self, workflow: TrainingWorkflow, stages: FakeStages, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        stages.outcomes = [StageOutcome(waiting="the store fails: no route"), StageOutcome(waiting="the store fails")]
        assert run_stage(workflow, "publish").cause == ""  # it fails for writes alone: nobody can look for its end
        monkeypatch.setattr(Surroundings, "store", lambda self: Missing(Cause.STORE, "the store fails: no answer"))
        outcome = run_stage(workflow, "publish")
        assert (outcome.waiting, outcome.cause) == ("the store fails", "store")

    def test_a_publication_that_is_killed_while_the_store_is_away_waits(
        self, workflow: TrainingWorkflow, stages: FakeStages, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr(Surroundings, "store", lambda self: Missing(Cause.STORE, "the store fails: no answer"))
        stages.outcomes = [StageOutcome("publish: ended by SIGKILL", killed=True)] * 3
        outcome = run_stage(workflow, "publish")
        assert (outcome.waiting, outcome.cause) == ("the store fails: no answer", "store")


class FakeSaving:
    """Where machines share no folder; the store is away at the end of a stage."""

    def __init__(self, capture: Path) -> None:
        self.claims = 0
        self._capture = capture

    def path_of_capture(self, attempt: object) -> Path:
        return self._capture

    def capture(self, job_id: str, submitted: Path) -> Path:
        return submitted

    def taken(self, attempt: object) -> bool:
        return False

    async def claim(self, attempt: object) -> StageOutcome:
        self.claims += 1
        return StageOutcome()

    @contextlib.asynccontextmanager
    async def meanwhile(self, attempt: object, on_taken: object) -> AsyncIterator[None]:
        yield

    async def save(self, attempt: object) -> StageOutcome:
        return StageOutcome(waiting="the store fails", cause=Cause.STORE)


class TestRunsInTheStore:
    """The job's run is fetched before a stage and saved after it."""

    def test_a_run_whose_capture_is_not_here_is_not_fetched(self, workflow: TrainingWorkflow, tmp_path: Path) -> None:
        saving = FakeSaving(tmp_path / "elsewhere")
        workflow.saving = cast(RunSaving, saving)
        assert run_stage(workflow).cause == Cause.CAPTURE
        assert saving.claims == 0
        assert workflow.missed_capture() is not None

    def test_a_stage_whose_results_are_not_saved_is_not_complete(
        self, workflow: TrainingWorkflow, stages: FakeStages, tmp_path: Path
    ) -> None:
        workflow.saving = cast(RunSaving, FakeSaving(tmp_path / "capture"))
        stages.outcomes = [StageOutcome()]
        assert run_stage(workflow) == StageOutcome(waiting="the store fails", cause=Cause.STORE)

    def test_but_a_scene_that_is_published_stays_so(
        self, workflow: TrainingWorkflow, stages: FakeStages, tmp_path: Path
    ) -> None:
        workflow.saving = cast(RunSaving, FakeSaving(tmp_path / "capture"))
        stages.outcomes = [StageOutcome()]
        assert run_stage(workflow, "publish") == StageOutcome()


class TestMissedCapture:
    """A worker that did not see a job's capture leaves jobs to others for a while."""

    def test_it_is_told_while_the_capture_is_away(
        self, workflow: TrainingWorkflow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        assert workflow.missed_capture() is None
        (tmp_path / "capture" / "frame.jpg").unlink()
        run_stage(workflow)
        missed = workflow.missed_capture()
        assert missed is not None
        assert missed.cause is Cause.CAPTURE
        (tmp_path / "capture" / "frame.jpg").touch()
        assert workflow.missed_capture() is None

    def test_it_is_forgotten_after_a_while(
        self, workflow: TrainingWorkflow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        (tmp_path / "capture" / "frame.jpg").unlink()
        run_stage(workflow)
        monkeypatch.setattr(workflows, "AWAY", 0.0)
        assert workflow.missed_capture() is None


class TestReports:
    """The reports of a running stage."""

    def test_reports_that_cannot_be_written_do_not_end_the_stage(
        self, workflow: TrainingWorkflow, stages: FakeStages, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def refuse(*arguments: object) -> bool:
            raise OSError(errno.EIO, os.strerror(errno.EIO))

        monkeypatch.setattr(JobTable, "progress", refuse)
        stages.outcomes, stages.reports = [StageOutcome()], [Progress("train", 1, 2)]
        assert run_stage(workflow) == StageOutcome()


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
        self, workflow: TrainingWorkflow, table: JobTable, engine: sa.Engine, home: Home
    ) -> None:
        with engine.begin() as connection:
            table.put_off(connection, "a", 1, "its worker was slow")
        workflow._finish("a", 1)
        assert row(table).state is JobState.WAITING
        assert self.scenes(home) == ["a"]
