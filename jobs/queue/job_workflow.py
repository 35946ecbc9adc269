"""The durable workflow of a job: its stages in order, each a step that is recorded when it is complete."""

from __future__ import annotations

import logging
import time
from typing import assert_never

import sqlalchemy as sa
from dbos import DBOS, DBOSClient
from dbos._error import DBOSWorkflowCancelledError, DBOSWorkflowConflictIDError

from jobs.artifacts.artifact_store import open_store
from jobs.home.database_faults import DATABASE_FAULTS, persist
from jobs.home.home import Home
from jobs.home.passing_faults import one_line
from jobs.home.stage_settings import STAGES
from jobs.process.stage_outcome import Done, Failed, Killed, StageOutcome, Waits, read_outcome, record_of
from jobs.process.stage_runner import StageRunner
from jobs.queue.enqueue import TRAIN_JOB, ask_for_help, enqueue, workflow_id
from jobs.queue.retry_pause import retry_pause
from jobs.queue.stage_attempt import StageAttempt
from jobs.records.job import JobState
from jobs.records.job_table import JobTable
from jobs.runs.readiness import Surroundings
from jobs.runs.run_saving import RunSaving

__all__ = ["MAX_TAKE_OVERS", "TrainingWorkflow"]

MAX_TAKE_OVERS = 20  # workers that may die under one attempt before it is given up
WELL = 300.0  # seconds of work after which the next wait is again the first

log = logging.getLogger(__name__)


class TrainingWorkflow:
    """The workflow as one worker runs it."""

    def __init__(
        self, home: Home, surroundings: Surroundings, engine: sa.Engine, queue: DBOSClient, stages: StageRunner
    ) -> None:
        self.attended: set[tuple[str, int]] = set()  # the attempts that this process works on, as (job id, attempt)
        self._home = home
        self._surroundings = surroundings
        self._engine = engine
        self._table = JobTable(engine)
        self._queue = queue
        self._stages = stages
        self.saving = RunSaving(home)

    def register(self) -> None:
        """Tell DBOS about the workflow; call once per process, before DBOS is launched."""

        @DBOS.step(name="run_stage", preemptible=True)
        async def run_stage(stage: str, job_id: str, attempt: int) -> dict[str, str]:
            """Run a stage and return its outcome.

            Errors are returned and not raised: DBOS records a step's outcome only while this worker owns the workflow,
            so a worker that was given up for dead learns it here, before it touches the job's row.
            """
            return record_of(await self._stage_attempt(stage, job_id, attempt).run())

        @DBOS.workflow(name=TRAIN_JOB, max_recovery_attempts=MAX_TAKE_OVERS)
        async def train_job(job_id: str, attempt: int, waits: int = 0, first: str = STAGES[0]) -> None:
            began = time.monotonic()
            self.attended.add((job_id, attempt))
            try:
                epoch = await persist(self._table.start, job_id, attempt)
                if not epoch:
                    return
                self.saving.begin((job_id, attempt), epoch)
                outcome: StageOutcome = Done()
                stage = first
                try:
                    for stage in STAGES[STAGES.index(first) :]:
                        outcome = read_outcome(await run_stage(stage, job_id, attempt))
                        if not isinstance(outcome, Done):
                            break
                except DATABASE_FAULTS as fault:  # the outcome of a stage could not be recorded
                    outcome = Waits(f"the job database fails: {one_line(getattr(fault, 'orig', None) or fault)}")
                except (DBOSWorkflowCancelledError, DBOSWorkflowConflictIDError):
                    # A stage that a cancellation meets at its very end is no longer ours to record.
                    if stage == "publish":
                        await persist(self._withdraw, job_id, attempt)
                    raise
                match outcome:
                    case Done():
                        await persist(self._finish, job_id, attempt)
                    case Failed(error) | Killed(error):
                        await persist(self._table.fail, job_id, attempt, error)
                    case Waits():
                        again = 0 if time.monotonic() - began > WELL else waits  # it was well in between
                        await persist(self._put_off, job_id, attempt, outcome, again, stage)
                    case _:
                        assert_never(outcome)
            finally:
                self.saving.end((job_id, attempt))
                self.attended.discard((job_id, attempt))

    def _stage_attempt(self, stage: str, job_id: str, attempt: int) -> StageAttempt:
        return StageAttempt(
            stage,
            job_id,
            attempt,
            home=self._home,
            surroundings=self._surroundings,
            table=self._table,
            stages=self._stages,
            saving=self.saving,
            ask_for_help=self._ask_for_help,
        )

    def _ask_for_help(self, job_id: str, attempt: int, helpers: int) -> None:
        job = self._table.get(job_id)
        if job is not None:
            with self._engine.begin() as connection:
                ask_for_help(self._queue, connection, job_id, attempt, helpers, job.priority)

    def _put_off(self, job_id: str, attempt: int, outcome: Waits, waits: int, first: str) -> None:
        """Queue the job's next attempt for later, unless the job is finished."""
        delay = retry_pause(waits)
        job = self._table.get(job_id)
        if job is None:
            return
        with self._engine.begin() as connection:
            if self._table.put_off(connection, job_id, attempt, outcome.reason, outcome.cause):
                more = min(waits + 1, 20)
                enqueue(
                    self._queue,
                    connection,
                    job_id,
                    attempt + 1,
                    delay=delay,
                    waits=more,
                    first=first,
                    time_limit=job.time_limit,
                )
                log.warning("%s waits for %g s: %s", job_id, delay, outcome.reason)

    def _finish(self, job_id: str, attempt: int) -> None:
        self.saving.complete((job_id, attempt))
        if not self._table.succeed(job_id, attempt, job_id):
            job = self._table.get(job_id)
            if job is not None and job.state is JobState.CANCELLED:
                # Cancelled between the publication and now: what a cancelled job made is not shown.
                open_store(self._home).remove_scene(job_id)

    def _withdraw(self, job_id: str, attempt: int) -> None:
        """Take the scene of a cancelled attempt back, unless the job has gone on since, here or with another worker."""
        job = self._table.get(job_id)
        if job is not None and (job.attempt != attempt or job.state is JobState.SUCCEEDED):
            return
        name = [workflow_id(job_id, attempt)]
        # The row says so a moment later than the workflow.
        if (
            job is None
            or job.state is JobState.CANCELLED
            or self._queue.list_workflows(workflow_ids=name, status="CANCELLED", load_input=False, load_output=False)
        ):
            open_store(self._home).remove_scene(job_id)
