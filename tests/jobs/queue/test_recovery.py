"""One worker's look after the others, on a real table of jobs and stand-ins for DBOS and the proof of life.

With real workers that really die it is tested in test_kill.py.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
import sqlalchemy as sa
from dbos import DBOS

from jobs.home.passing_faults import Cause
from jobs.process.stage_runner import StageRunner
from jobs.queue import recovery
from jobs.queue.liveness import Liveness
from jobs.queue.recovery import Recovery
from jobs.records.job import Job, JobState
from jobs.records.job_table import JobTable
from jobs.runs.readiness import Surroundings


@dataclass
class Workflow:
    """A row of DBOS."""

    workflow_id: str
    status: str = "PENDING"
    executor_id: str = "us"
    error: Exception | None = None
    workflow_deadline_epoch_ms: int | None = None


@dataclass
class FakeDbos:
    """A list of workflows, and DBOS's conditional way back into the queue."""

    workflows: list[Workflow] = field(default_factory=list)
    delays: dict[str, float] = field(default_factory=dict)

    def set_workflow_delay(self, workflow_id: str, *, delay_seconds: float) -> None:
        self.delays[workflow_id] = delay_seconds

    def list_workflows(
        self,
        *,
        workflow_ids: Collection[str] | None = None,
        status: str | None = None,
        executor_id: str | None = None,
        **unused: Any,
    ) -> list[Workflow]:
        return [
            workflow
            for workflow in self.workflows
            if (workflow_ids is None or workflow.workflow_id in workflow_ids)
            and status in (None, workflow.status)
            and executor_id in (None, workflow.executor_id)
        ]

    def reenqueue_for_recovery(self, workflow_id: str, executors: list[str], queue: str) -> bool:
        assert queue == "training"
        for workflow in self.list_workflows(workflow_ids=[workflow_id], status="PENDING"):
            if workflow.executor_id in executors:
                workflow.status, workflow.executor_id = "ENQUEUED", ""
                return True
        return False


@dataclass
class FakeStages:
    running: list[str] = field(default_factory=list)
    abandoned: list[str] = field(default_factory=list)

    def workflows(self) -> list[str]:
        return self.running

    def abandon(self, workflow: str) -> None:
        self.abandoned.append(workflow)


@dataclass
class FakeLiveness:
    dead: set[str] = field(default_factory=set)
    suspected: set[str] = field(default_factory=set)

    @contextlib.contextmanager
    def claim_dead(self, executor: str) -> Iterator[bool]:
        yield executor in self.dead

    def suspects(self, executor: str) -> bool:
        return executor in self.suspected


@dataclass
class FakeSurroundings:
    seen: set[str]

    def is_back(self, cause: str, capture: Path) -> bool:
        return cause in self.seen


@pytest.fixture
def seen() -> set[str]:
    """The causes of waiting as this machine sees them."""
    return set()


@pytest.fixture
def table(engine: sa.Engine) -> JobTable:
    """The table with the jobs "a" and "b" in their first attempts."""
    table = JobTable(engine)
    for job_id in ("a", "b"):
        with engine.begin() as connection:
            table.insert(connection, Job(id=job_id, title="", capture="", config={}))
        table.start(job_id, 1)
    return table


@pytest.fixture
def dbos(monkeypatch: pytest.MonkeyPatch) -> FakeDbos:
    fake = FakeDbos()
    monkeypatch.setattr(recovery, "DBOS", fake)
    return fake


@pytest.fixture
def stages() -> FakeStages:
    return FakeStages()


@pytest.fixture
def liveness() -> FakeLiveness:
    return FakeLiveness()


@pytest.fixture
def attended() -> set[tuple[str, int]]:
    """The attempts that this worker works on."""
    return set()


@pytest.fixture
def ours(
    dbos: FakeDbos,
    table: JobTable,
    stages: FakeStages,
    liveness: FakeLiveness,
    attended: set[tuple[str, int]],
    seen: set[str],
) -> Recovery:
    """This worker's part; it is "us"."""
    system = cast(DBOS, SimpleNamespace(_sys_db=dbos))
    machine = cast(Surroundings, FakeSurroundings(seen))
    return Recovery(system, "us", table, cast(StageRunner, stages), cast(Liveness, liveness), attended, machine)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Return a function that sets the clock that runs on."""
    now = [1000.0]
    stopped = SimpleNamespace(monotonic=lambda: now[0], time=time.time)
    monkeypatch.setattr(recovery, "time", stopped)

    def advance(seconds: float) -> None:
        now[0] += seconds

    return advance


def row(table: JobTable, job_id: str = "a") -> Job:
    job = table.get(job_id)
    assert job is not None
    return job


@pytest.mark.parametrize(
    ("workflow", "abandoned"),
    [
        (Workflow("a:1"), False),
        (Workflow("a:1", executor_id="another"), True),
        (Workflow("a:1", "ENQUEUED", ""), True),
        (Workflow("a:1", "CANCELLED", "another"), False),  # its stage is told in another way
    ],
    ids=["ours", "of another worker", "queued again", "cancelled"],
)
def test_stages_of_workflows_that_another_has_taken_are_killed(
    ours: Recovery, dbos: FakeDbos, stages: FakeStages, workflow: Workflow, abandoned: bool
) -> None:
    dbos.workflows, stages.running = [workflow], ["a:1"]
    ours.give_up_lost()
    assert stages.abandoned == (["a:1"] if abandoned else [])


def test_the_workflows_of_a_dead_worker_are_queued_again(
    ours: Recovery, dbos: FakeDbos, table: JobTable, liveness: FakeLiveness
) -> None:
    dbos.workflows = [Workflow("a:1", executor_id="dead"), Workflow("b:1", executor_id="alive")]
    liveness.dead = {"dead"}
    assert ours.take_over() is False
    assert [workflow.status for workflow in dbos.workflows] == ["ENQUEUED", "PENDING"]
    assert (row(table, "a").state, row(table, "b").state) == (JobState.QUEUED, JobState.RUNNING)
    assert row(table, "a").waiting == "its worker died; the next free one goes on with it"


def test_a_worker_that_is_only_suspected_keeps_its_work_and_calls_for_patience(
    ours: Recovery, dbos: FakeDbos, liveness: FakeLiveness
) -> None:
    dbos.workflows, liveness.suspected = [Workflow("a:1", executor_id="slow")], {"slow"}
    assert ours.take_over() is True
    assert dbos.workflows[0].status == "PENDING"


def test_a_row_of_a_later_attempt_is_left_alone(
    ours: Recovery, dbos: FakeDbos, table: JobTable, engine: sa.Engine, liveness: FakeLiveness
) -> None:
    with engine.begin() as connection:
        table.put_off(connection, "a", 1, "the store is away")
    table.start("a", 2)
    dbos.workflows, liveness.dead = [Workflow("a:1", executor_id="dead")], {"dead"}
    ours.take_over()
    assert (row(table).state, row(table).attempt, row(table).waiting) == (JobState.RUNNING, 2, "")


def test_a_row_that_the_next_worker_has_changed_already_is_left_alone(
    ours: Recovery, dbos: FakeDbos, table: JobTable, liveness: FakeLiveness, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It takes the workflow between its way into the queue and the change of the row."""
    queue_again = dbos.reenqueue_for_recovery

    def taken_at_once(workflow_id: str, executors: list[str], queue: str) -> bool:
        queued = queue_again(workflow_id, executors, queue)
        time.sleep(0.01)  # the row's date must differ
        table.start("a", 1)
        return queued

    monkeypatch.setattr(dbos, "reenqueue_for_recovery", taken_at_once)
    dbos.workflows, liveness.dead = [Workflow("a:1", executor_id="dead")], {"dead"}
    ours.take_over()
    assert (row(table).state, row(table).waiting) == (JobState.RUNNING, "")


def test_who_comes_second_changes_no_row(
    ours: Recovery, dbos: FakeDbos, table: JobTable, liveness: FakeLiveness, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dbos, "reenqueue_for_recovery", lambda *_: False)  # another worker was there before
    dbos.workflows, liveness.dead = [Workflow("a:1", executor_id="dead")], {"dead"}
    ours.take_over()
    assert (row(table).state, row(table).waiting) == (JobState.RUNNING, "")


def test_our_own_workflow_that_nobody_works_on_is_queued_again_after_a_while(
    ours: Recovery, dbos: FakeDbos, table: JobTable, clock: Callable[[float], None], attended: set[tuple[str, int]]
) -> None:
    dbos.workflows = [Workflow("a:1"), Workflow("b:1")]
    attended.add(("b", 1))
    ours.take_over()
    clock(9.9)
    ours.take_over()
    assert [workflow.status for workflow in dbos.workflows] == ["PENDING", "PENDING"]
    clock(0.2)
    ours.take_over()
    assert [workflow.status for workflow in dbos.workflows] == ["ENQUEUED", "PENDING"]
    assert row(table).waiting == "it was interrupted; the next free worker goes on with it"


def test_the_while_begins_anew_when_somebody_worked_on_it_in_between(
    ours: Recovery, dbos: FakeDbos, clock: Callable[[float], None], attended: set[tuple[str, int]]
) -> None:
    dbos.workflows = [Workflow("a:1")]
    ours.take_over()
    clock(6)
    attended.add(("a", 1))
    ours.take_over()
    attended.clear()
    clock(6)
    ours.take_over()
    assert dbos.workflows[0].status == "PENDING"


@pytest.mark.parametrize(
    ("status", "state", "error"),
    [
        ("CANCELLED", JobState.CANCELLED, ""),
        ("ERROR", JobState.FAILED, "internal error: no such column"),
        ("MAX_RECOVERY_ATTEMPTS_EXCEEDED", JobState.FAILED, "given up: 20 workers died while they ran this job"),
        ("PENDING", JobState.RUNNING, ""),
    ],
)
def test_rows_follow_workflows_that_ended_without_a_word(
    ours: Recovery, dbos: FakeDbos, table: JobTable, status: str, state: JobState, error: str
) -> None:
    dbos.workflows = [Workflow("a:1", status, error=Exception("no such column")), Workflow("b:1")]
    ours.settle()
    assert (row(table).state, row(table).error) == (state, error)
    assert row(table, "b").state is JobState.RUNNING


def test_a_worker_says_every_20_seconds_that_its_job_is_worked_on(
    ours: Recovery,
    table: JobTable,
    clock: Callable[[float], None],
    attended: set[tuple[str, int]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    words: list[tuple[str, int]] = []
    monkeypatch.setattr(table, "keep_alive", lambda job_id, attempt: words.append((job_id, attempt)))
    attended.add(("a", 1))
    counts = []
    for _ in range(9):  # every 5 s
        ours.keep_alive()
        counts.append(len(words))
        clock(5)
    assert counts == [1, 1, 1, 1, 2, 2, 2, 2, 3]
    assert set(words) == {("a", 1)}


def test_a_worker_that_leaves_queues_its_own_work_again_and_nothing_else(
    ours: Recovery, dbos: FakeDbos, table: JobTable
) -> None:
    dbos.workflows = [Workflow("a:1"), Workflow("b:1", executor_id="another")]
    ours.leave()
    assert [workflow.status for workflow in dbos.workflows] == ["ENQUEUED", "PENDING"]
    assert row(table).waiting == "its worker was stopped; the next free one goes on with it"
    assert row(table, "b").state is JobState.RUNNING


class TestWaking:
    """Jobs with a long pause after the end of its cause."""

    @pytest.fixture(autouse=True)
    def _waiting(self, table: JobTable, engine: sa.Engine, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(recovery, "WAKE", 0.0)
        with engine.begin() as connection:
            table.put_off(connection, "a", 1, "the store fails", Cause.STORE)
            table.put_off(connection, "b", 1, "the capture's folder is empty", Cause.CAPTURE)

    def test_while_nothing_is_seen_they_wait(self, ours: Recovery, dbos: FakeDbos, table: JobTable) -> None:
        ours.wake()
        assert dbos.delays == {}
        assert row(table, "a").state is JobState.WAITING

    def test_what_is_seen_again_ends_the_pause(
        self, ours: Recovery, dbos: FakeDbos, table: JobTable, seen: set[str]
    ) -> None:
        seen.add("store")
        ours.wake()
        assert dbos.delays == {"a:2": 0}
        assert (row(table, "a").state, row(table, "b").state) == (JobState.QUEUED, JobState.WAITING)
