"""The durable workflow of a helper: one segment of a job that another worker has."""

from __future__ import annotations

import asyncio
import logging
import shutil
from typing import assert_never

import sqlalchemy as sa
from dbos import DBOS

from hgs_core.base.progress import Progress
from jobs.home.database_faults import DATABASE_FAULTS
from jobs.home.home import Home
from jobs.home.passing_faults import one_line
from jobs.home.stage_settings import HELP
from jobs.process.stage_outcome import Done, Failed, Killed, StageOutcome, Waits
from jobs.process.stage_runner import StageRunner
from jobs.queue.enqueue import HELP_JOB, helper_name, workflow_id
from jobs.records.job import JobState
from jobs.records.job_table import JobTable
from jobs.runs.stored_segments import help_folder

__all__ = ["HelperWorkflow"]

LOOK = 2.0  # seconds between two looks whether the job still runs
MAX_TAKE_OVERS = 20  # workers that may die under one helper before it is given up: the job's own makes its segment

log = logging.getLogger(__name__)


class HelperWorkflow:
    """The workflow as one worker runs it. A helper's failure is not the job's: its own worker meets it, too."""

    def __init__(self, home: Home, engine: sa.Engine, stages: StageRunner, attended: set[tuple[str, int]]) -> None:
        """Note the work of this process in `attended`, under the helpers' names."""
        self._home = home
        self._table = JobTable(engine)
        self._stages = stages
        self._attended = attended

    def register(self) -> None:
        """Tell DBOS about the workflow; call once per process, before DBOS is launched."""

        @DBOS.step(name="run_help", preemptible=True)
        async def run_help(job_id: str, number: int, attempt: int) -> str:
            return await self._help(job_id, number, attempt)

        @DBOS.workflow(name=HELP_JOB, max_recovery_attempts=MAX_TAKE_OVERS)
        async def help_job(job_id: str, number: int, attempt: int) -> None:
            helper = helper_name(job_id, number), attempt
            self._attended.add(helper)
            try:
                await run_help(job_id, number, attempt)
            finally:
                self._attended.discard(helper)

    async def _help(self, job_id: str, number: int, attempt: int) -> str:
        """Make a segment that nobody makes; return why that came to nothing, if it did."""

        async def unheard(progress: Progress) -> None:
            return

        if not await asyncio.to_thread(self._is_running, job_id, attempt):
            return "the job is not running"
        name = workflow_id(helper_name(job_id, number), attempt)
        run = self._home.run(job_id)
        if self._home.runs_in_store:  # its results go there; the run's copy here is another worker's
            run = help_folder(self._home, helper_name(job_id, number))
            run.mkdir(parents=True, exist_ok=True)
        stage = asyncio.create_task(self._stages.run(name, HELP, run, unheard))
        try:
            while not stage.done():
                await asyncio.wait({stage}, timeout=LOOK)
                if not stage.done() and not await asyncio.to_thread(self._is_running, job_id, attempt):
                    return "the job is not running any more"
            outcome: StageOutcome = await stage
        except OSError as error:  # it could not even be started
            outcome = Failed(one_line(error))
        finally:
            stage.cancel()
            await asyncio.gather(stage, return_exceptions=True)
            if self._home.runs_in_store:
                shutil.rmtree(run, ignore_errors=True)
        match outcome:
            case Done():
                return ""
            case Failed(reason) | Waits(reason) | Killed(reason):
                log.warning("%s: help came to nothing: %s", job_id, reason)
                return reason
            case _:
                assert_never(outcome)

    def _is_running(self, job_id: str, attempt: int) -> bool:
        try:
            job = self._table.get(job_id)
        except DATABASE_FAULTS:  # nobody knows
            return True
        return job is not None and job.state is JobState.RUNNING and job.attempt == attempt
