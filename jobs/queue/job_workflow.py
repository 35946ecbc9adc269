"""The durable workflow of a job: its stages in order, each a step that is recorded when it is complete."""

from __future__ import annotations

import asyncio
import dataclasses
import functools
import logging
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from dbos import DBOS, DBOSClient

from hgs_core.base.progress import Progress
from jobs.artifacts.artifact_store import open_store
from jobs.home.database_faults import DATABASE_FAULTS, persist
from jobs.home.home import Home
from jobs.home.passing_faults import Cause, one_line, passing_fault
from jobs.home.stage_settings import STAGES
from jobs.process.stage_outcome import StageOutcome
from jobs.process.stage_pace import StagePace
from jobs.process.stage_runner import OwnershipLost, StageRunner
from jobs.queue.enqueue import TRAIN_JOB, ask_for_help, enqueue, workflow_id
from jobs.records.job import JobState
from jobs.records.job_table import JobTable
from jobs.runs.progress_log import CourseWriter
from jobs.runs.readiness import Missing, Surroundings
from jobs.runs.run_saving import RunSaving
from jobs.runs.shared_segments import MADE, SEGMENTS

__all__ = ["MAX_TAKE_OVERS", "TrainingWorkflow"]

MAX_TAKE_OVERS = 20  # workers that may die under one attempt before it is given up
STAGE_TRIES = 3  # starts of a stage that signals end, one after the other, before it has come any further
FIRST_WAIT, LONGEST_WAIT = 5.0, 7200.0  # seconds that a job is put off for when a fault passes: doubled each time
AWAY = 60.0  # seconds that a worker leaves jobs to others after it has not seen the capture of one
WELL = 300.0  # seconds of work after which the next wait is again the first

log = logging.getLogger(__name__)


class TrainingWorkflow:
    """The workflow as one worker runs it."""

    def __init__(
        self, home: Home, surroundings: Surroundings, engine: sa.Engine, queue: DBOSClient, stages: StageRunner
    ) -> None:
        self.attended: set[tuple[str, int]] = set()  # the attempts that this process works on, as (job id, attempt)
        self._home = home
        self._missed: tuple[Path, float] | None = None  # the last capture that this machine did not see, and when
        self._surroundings = surroundings
        self._engine = engine
        self._table = JobTable(engine)
        self._queue = queue
        self._stages = stages
        self.saving = RunSaving(home)

    def register(self) -> None:
        """Tell DBOS about the workflow; call once per process, before DBOS is launched."""

        @DBOS.step(name="run_stage", preemptible=True)
        async def run_stage(stage: str, job_id: str, attempt: int) -> dict[str, Any]:
            """Run a stage and return its outcome.

            Errors are returned and not raised: DBOS records a step's outcome only while this worker owns the workflow,
            so a worker that was given up for dead learns it here, before it touches the job's row.
            """
            return dataclasses.asdict(await self._run_stage(stage, job_id, attempt))

        @DBOS.workflow(name=TRAIN_JOB, max_recovery_attempts=MAX_TAKE_OVERS)
        async def train_job(job_id: str, attempt: int, waits: int = 0, first: str = STAGES[0]) -> None:
            began = time.monotonic()
            self.attended.add((job_id, attempt))
            try:
                epoch = await persist(self._table.start, job_id, attempt)
                if not epoch:
                    return
                self.saving.begin((job_id, attempt), epoch)
                outcome, stage = StageOutcome(), first
                try:
                    for stage in STAGES[STAGES.index(first) :]:
                        recorded = await run_stage(stage, job_id, attempt)
                        # Workers of earlier versions recorded the error alone.
                        outcome = StageOutcome(**recorded) if isinstance(recorded, dict) else StageOutcome(recorded)
                        if outcome != StageOutcome():
                            break
                except DATABASE_FAULTS as error:  # the outcome of a stage could not be recorded
                    reason = one_line(getattr(error, "orig", None) or error)
                    outcome = StageOutcome(waiting=f"the job database fails: {reason}")
                if outcome.waiting:
                    again = 0 if time.monotonic() - began > WELL else waits  # it was well in between
                    await persist(self._put_off, job_id, attempt, outcome, again, stage)
                elif outcome.error:
                    await persist(self._table.fail, job_id, attempt, outcome.error)
                else:
                    await persist(self._finish, job_id, attempt)
            finally:
                self.saving.end((job_id, attempt))
                self.attended.discard((job_id, attempt))

    def _ask_for_help(self, job_id: str, attempt: int, helpers: int) -> None:
        job = self._table.get(job_id)
        if job is not None:
            with self._engine.begin() as connection:
                ask_for_help(self._queue, connection, job_id, attempt, helpers, job.priority)

    def missed_capture(self) -> Missing | None:
        """Return the capture that this machine lately did not see and still does not: another machine may see it.

        After a minute that is forgotten, since the capture may be gone for good.
        """
        if self._missed is None or time.monotonic() - self._missed[1] > AWAY:
            return None
        lacking = self._surroundings.of_job(self._missed[0])
        if lacking is None:
            self._missed = None
        return lacking

    async def _run_stage(self, stage: str, job_id: str, attempt: int) -> StageOutcome:
        course = CourseWriter(self._home.run(job_id), attempt)
        pace = StagePace()

        def write_down(progress: Progress) -> None:
            if self._table.progress(job_id, attempt, progress, pace.ends(progress, time.time())):
                course.add(progress)

        async def unless_it_fails(write: Callable[[Progress], object], progress: Progress) -> None:
            try:
                await asyncio.to_thread(write, progress)
            except Exception as error:
                log.warning("progress of %s was not written: %s", job_id, one_line(error))

        reached: dict[str, int] = {}
        tries = 0
        asked = False

        async def on_progress(progress: Progress) -> None:
            nonlocal asked, tries
            free = int(progress.figures.get(SEGMENTS, 0) - progress.figures.get(MADE, 0))
            if not asked and free > 1 and progress.figures.get(MADE):  # one is made here
                asked = True
                await self.saving.save((job_id, attempt))  # helpers begin with what the first one left
                await persist(self._ask_for_help, job_id, attempt, free - 1)
            if progress.done > reached.get(progress.stage, 0):
                reached[progress.stage] = progress.done
                tries = 1
            await unless_it_fails(write_down, progress)

        # The course has none of this: a stage that goes on from a checkpoint does not begin anew.
        await unless_it_fails(functools.partial(self._table.progress, job_id, attempt), Progress(stage, 0, 1))
        claimed = await self._claim(stage, (job_id, attempt))
        if claimed != StageOutcome():
            return claimed
        lacking = await persist(self._lacking, job_id, stage)
        if lacking is not None:  # seen before the stage begins: encoding does with less where there is no capture
            return StageOutcome(waiting=lacking.reason, cause=lacking.cause)
        outcome = StageOutcome()
        while tries < STAGE_TRIES:
            tries += 1
            try:
                outcome = await self._saved_stage(stage, job_id, attempt, on_progress)
            except OSError as error:  # it could not even be started
                fault = passing_fault(error)
                outcome = StageOutcome(one_line(error), "" if fault is None else fault.reason)
            if not outcome.killed or self.saving.taken((job_id, attempt)):
                break
            log.warning("%s, start %d of %d without progress: %s", job_id, tries, STAGE_TRIES, outcome.error)
        if outcome.error or outcome.waiting:
            lacking = await persist(self._lacking, job_id, stage)
            if lacking is None and stage == "publish":
                lacking = await asyncio.to_thread(self._surroundings.store)
            if lacking is not None:
                outcome = dataclasses.replace(outcome, waiting=outcome.waiting or lacking.reason, cause=lacking.cause)
        return outcome

    async def _claim(self, stage: str, attempt: tuple[str, int]) -> StageOutcome:
        """Have the run here; not that of a capture which this machine does not see, as large as it may be."""
        capture = await asyncio.to_thread(self.saving.path_of_capture, attempt)
        if capture is not None and stage != "publish":
            lacking = await asyncio.to_thread(self._surroundings.of_job, capture)
            if lacking is not None:
                if lacking.cause is Cause.CAPTURE:
                    self._missed = capture, time.monotonic()
                return StageOutcome(waiting=lacking.reason, cause=lacking.cause)
        claimed = await self.saving.claim(attempt)
        if claimed.waiting and not claimed.cause and (missing := await asyncio.to_thread(self._surroundings.home)):
            return dataclasses.replace(claimed, cause=missing.cause)
        return claimed

    async def _saved_stage(
        self, stage: str, job_id: str, attempt: int, on_progress: Callable[[Progress], Awaitable[None]]
    ) -> StageOutcome:
        """Run a stage once and save its results; a stage without saved results has failed."""
        name = workflow_id(job_id, attempt)
        try:
            async with self.saving.meanwhile((job_id, attempt), lambda: self._stages.abandon(name)):
                outcome = await self._stages.run(name, stage, self._home.run(job_id), on_progress)
        except OwnershipLost:
            if not self.saving.taken((job_id, attempt)):
                raise
        else:
            saved = await self.saving.save((job_id, attempt))
            if outcome != StageOutcome() or (stage == "publish" and not self.saving.taken((job_id, attempt))):
                return outcome
            return saved
        return await self.saving.save((job_id, attempt))

    def _lacking(self, job_id: str, stage: str) -> Missing | None:
        """Return the lack of this machine for a stage, apart from the store."""
        job = self._table.get(job_id)
        if job is None:
            return None
        if stage == "publish":  # needs no capture
            return self._surroundings.home()
        capture = self.saving.capture(job_id, Path(job.capture))
        lacking = self._surroundings.of_job(capture)
        if lacking is not None and lacking.cause is Cause.CAPTURE:
            self._missed = capture, time.monotonic()
        return lacking

    def _put_off(self, job_id: str, attempt: int, outcome: StageOutcome, waits: int, first: str) -> None:
        """Queue the job's next attempt for later, unless the job is finished."""
        delay = min(FIRST_WAIT * 2.0**waits, LONGEST_WAIT)
        job = self._table.get(job_id)
        if job is None:
            return
        with self._engine.begin() as connection:
            if self._table.put_off(connection, job_id, attempt, outcome.waiting, outcome.cause):
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
                log.warning("%s waits for %g s: %s", job_id, delay, outcome.waiting)

    def _finish(self, job_id: str, attempt: int) -> None:
        self.saving.complete((job_id, attempt))
        if not self._table.succeed(job_id, attempt, job_id):
            job = self._table.get(job_id)
            if job is not None and job.state is JobState.CANCELLED:
                # Cancelled between the publication and now: what a cancelled job made is not shown.
                open_store(self._home).remove_scene(job_id)
