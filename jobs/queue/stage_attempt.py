"""One stage of an attempt at a job: claimed, started again while signals end it, saved."""

from __future__ import annotations

import asyncio
import functools
import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import assert_never

from hgs_core.base.progress import Progress
from hgs_core.runs.remaining_time import RemainingTime
from jobs.home.database_faults import persist
from jobs.home.home import Home
from jobs.home.passing_faults import one_line, passing_fault
from jobs.process.stage_outcome import Done, Failed, Killed, StageOutcome, Waits
from jobs.process.stage_runner import OwnershipLost, StageRunner
from jobs.queue.enqueue import workflow_id
from jobs.records.job_table import JobTable
from jobs.runs.progress_log import CourseWriter, read_course
from jobs.runs.readiness import Missing, Surroundings
from jobs.runs.run_saving import RunSaving
from jobs.runs.shared_segments import MADE, SEGMENTS

__all__ = ["StageAttempt"]

STAGE_TRIES = 3  # starts of a stage that signals end, one after the other, before it has come any further

log = logging.getLogger(__name__)


class StageAttempt:
    """One stage of an attempt at a job, on this machine."""

    def __init__(
        self,
        stage: str,
        job_id: str,
        attempt: int,
        *,
        home: Home,
        surroundings: Surroundings,
        table: JobTable,
        stages: StageRunner,
        saving: RunSaving,
        ask_for_help: Callable[[str, int, int], object],
    ) -> None:
        """Call `ask_for_help`, in a thread, with the job, its attempt and the number of helpers with work to do."""
        self._stage = stage
        self._job_id = job_id
        self._attempt = attempt
        self._home = home
        self._surroundings = surroundings
        self._table = table
        self._stages = stages
        self._saving = saving
        self._ask_for_help = ask_for_help
        self._tries = 0  # starts since the last progress
        self._reached: dict[str, int] = {}  # units done, by stage
        self._asked = False
        self._forecast = RemainingTime(None)
        self._course = CourseWriter(home.run(job_id), attempt)

    async def run(self) -> StageOutcome:
        """Run the stage and return its outcome; a lack of this machine is never its failure."""
        began = Progress(self._stage, 0, 1)
        # The course has none of this: a stage that goes on from a checkpoint does not begin anew.
        await self._unless_it_fails(functools.partial(self._table.progress, self._job_id, self._attempt), began)
        claimed = await self._claim()
        if not isinstance(claimed, Done):
            return claimed
        lacking = await persist(self._lacking)
        if lacking is not None:  # seen before the stage begins: encoding does with less where there is no capture
            return Waits(lacking.reason, lacking.cause)
        return await self._excused(await self._until_it_ends())

    async def _claim(self) -> StageOutcome:
        """Have the run here; not that of a capture which this machine does not see, as large as it may be."""
        capture = await asyncio.to_thread(self._saving.path_of_capture, self._key)
        if capture is not None and self._stage != "publish":
            lacking = await asyncio.to_thread(self._surroundings.of_job, capture)
            if lacking is not None:
                return Waits(lacking.reason, lacking.cause)
        claimed = await self._saving.claim(self._key)
        match claimed:
            case Waits(reason, None) if missing := await asyncio.to_thread(self._surroundings.home):
                return Waits(reason, missing.cause)
            case _:
                return claimed

    async def _until_it_ends(self) -> StageOutcome:
        """Start the stage, and again while it is killed but comes further."""
        while True:
            self._tries += 1
            outcome = await self._start()
            if not isinstance(outcome, Killed) or self._saving.taken(self._key):
                return outcome
            log.warning(
                "%s, start %d of %d without progress: %s", self._job_id, self._tries, STAGE_TRIES, outcome.error
            )
            if self._tries >= STAGE_TRIES:
                return outcome

    async def _start(self) -> StageOutcome:
        """Run the stage once and save its results; a stage without saved results has failed."""
        name = workflow_id(self._job_id, self._attempt)
        try:
            async with self._saving.meanwhile(self._key, lambda: self._stages.abandon(name)):
                outcome = await self._stages.run(name, self._stage, self._home.run(self._job_id), self._on_progress)
        except OwnershipLost:
            if not self._saving.taken(self._key):
                raise
        except OSError as error:  # it could not even be started
            fault = passing_fault(error)
            return Failed(one_line(error)) if fault is None else Waits(fault.reason, fault.cause)
        else:
            saved = await self._saving.save(self._key)
            if not isinstance(outcome, Done) or (self._stage == "publish" and not self._saving.taken(self._key)):
                return outcome
            return saved
        return await self._saving.save(self._key)

    async def _excused(self, outcome: StageOutcome) -> StageOutcome:
        """Return the outcome; a failure waits for the cause if this machine lacks anything."""
        if isinstance(outcome, Done):
            return outcome
        lacking = await persist(self._lacking)
        if lacking is None and self._stage == "publish":
            lacking = await asyncio.to_thread(self._surroundings.store)
        if lacking is None:
            return outcome
        match outcome:
            case Waits(reason):
                return Waits(reason, lacking.cause)
            case Failed() | Killed():
                return Waits(lacking.reason, lacking.cause)
            case _:
                assert_never(outcome)

    def _lacking(self) -> Missing | None:
        """Return the lack of this machine for the stage, apart from the store."""
        job = self._table.get(self._job_id)
        if job is None:
            return None
        if self._stage == "publish":  # needs no capture
            return self._surroundings.home()
        return self._surroundings.of_job(self._saving.capture(self._job_id, Path(job.capture)))

    async def _on_progress(self, progress: Progress) -> None:
        free = int(progress.figures.get(SEGMENTS, 0) - progress.figures.get(MADE, 0))
        if not self._asked and free > 1 and progress.figures.get(MADE):  # one is made here
            self._asked = True
            await self._saving.save(self._key)  # helpers begin with what the first one left
            await persist(self._ask_for_help, self._job_id, self._attempt, free - 1)
        if progress.done > self._reached.get(progress.stage, 0):
            self._reached[progress.stage] = progress.done
            self._tries = 1
        await self._unless_it_fails(self._write_down, progress)

    def _write_down(self, progress: Progress) -> None:
        if not self._forecast.predicted:
            self._forecast = self._forecast_so_far()
        now = time.time()
        left = self._forecast.after(progress, now)
        if self._table.progress(self._job_id, self._attempt, progress, 0.0 if left is None else now + left):
            self._course.add(progress)

    def _forecast_so_far(self) -> RemainingTime:
        """Return the forecast as the reports of this attempt's stages so far have corrected it."""
        run = self._home.run(self._job_id)
        forecast = RemainingTime.of_run(run)
        if forecast.predicted:
            for one in read_course(run):
                if one.attempt == self._attempt:
                    forecast.after(Progress(one.stage, one.done, one.total), one.time)
        return forecast

    async def _unless_it_fails(self, write: Callable[[Progress], object], progress: Progress) -> None:
        try:
            await asyncio.to_thread(write, progress)
        except Exception as error:
            log.warning("progress of %s was not written: %s", self._job_id, one_line(error))

    @property
    def _key(self) -> tuple[str, int]:
        return self._job_id, self._attempt
