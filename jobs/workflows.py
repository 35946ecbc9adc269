"""The durable workflow of a job: its stages in order, each a step that is recorded when it is complete."""

from __future__ import annotations

import asyncio
import logging

from dbos import DBOS

from hgs_core.base.progress import Progress
from jobs.artifacts import ArtifactStore
from jobs.client import TRAIN_JOB, workflow_id
from jobs.home import Home
from jobs.stage import STAGES
from jobs.store import JobState, JobTable
from jobs.subprocesses import StageOutcome, StageRunner

__all__ = ["MAX_TAKE_OVERS", "register_workflows"]

MAX_TAKE_OVERS = 20  # workers that may die under one attempt before it is given up
STAGE_TRIES = 3  # times that a stage is started again after a signal ended it

log = logging.getLogger(__name__)


def register_workflows(home: Home, table: JobTable, stages: StageRunner) -> None:
    """Tell DBOS about the workflow; call once per process, before DBOS is launched."""

    @DBOS.step(name="run_stage", preemptible=True)
    async def run_stage(stage: str, job_id: str, attempt: int) -> str:
        """Run a stage and return its error, empty on success.

        The error is returned and not raised: DBOS records a step's outcome only while this worker owns the workflow,
        so a worker that was given up for dead learns it here, before it touches the job's row.
        """

        async def on_progress(progress: Progress) -> None:
            try:
                await asyncio.to_thread(table.progress, job_id, attempt, progress)
            except Exception as error:
                log.warning("progress of %s was not written: %s", job_id, error)

        await on_progress(Progress(stage, 0, 1))
        outcome = StageOutcome()
        for _ in range(STAGE_TRIES):
            outcome = await stages.run(workflow_id(job_id, attempt), stage, home.run(job_id), on_progress)
            if not outcome.killed:
                break
        return outcome.error

    @DBOS.workflow(name=TRAIN_JOB, max_recovery_attempts=MAX_TAKE_OVERS)
    async def train_job(job_id: str, attempt: int) -> None:
        if not await asyncio.to_thread(table.start, job_id, attempt):
            return
        for stage in STAGES:
            error = await run_stage(stage, job_id, attempt)
            if error:
                await asyncio.to_thread(table.fail, job_id, attempt, error)
                return
        await asyncio.to_thread(finish, job_id, attempt)

    def finish(job_id: str, attempt: int) -> None:
        if not table.succeed(job_id, attempt, job_id):
            job = table.get(job_id)
            if job is not None and job.state is JobState.CANCELLED:
                # Cancelled between the publication and now: what a cancelled job made is not shown.
                ArtifactStore(home.store_url).remove_scene(job_id)
