"""The recovery of jobs by every worker: each unfinished job is worked on, or has a reason to wait.

A worker may die, lose a workflow to another, or be unable to write how one ended; then DBOS keeps the workflow as
pending for ever. Each worker looks for such workflows, its own included, and queues them again.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Collection
from pathlib import Path

from dbos import DBOS

from jobs.home.passing_faults import Cause
from jobs.process.stage_runner import StageRunner
from jobs.queue.enqueue import TRAINING_QUEUE, workflow_id
from jobs.queue.job_workflow import MAX_TAKE_OVERS
from jobs.queue.liveness import Liveness
from jobs.records.job_table import JobTable
from jobs.runs.readiness import Surroundings

__all__ = ["Recovery"]

UNATTENDED = 10.0  # seconds after which a workflow of ours that nothing here works on is queued again
WAKE = 5.0  # seconds between two looks whether what jobs wait for is back
KEEP_ALIVE = 20.0  # seconds between two words of a worker about the job that it works on

log = logging.getLogger(__name__)

Attempt = tuple[str, int]  # job id, attempt


class Recovery:
    """One worker's part in it; its methods are called from one thread, every few seconds."""

    def __init__(
        self,
        dbos: DBOS,
        executor: str,
        table: JobTable,
        stages: StageRunner,
        liveness: Liveness,
        attended: Collection[Attempt],
        surroundings: Surroundings,
    ) -> None:
        """Act as `executor`, at work on the `attended` attempts."""
        self._dbos = dbos
        self._executor = executor
        self._table = table
        self._stages = stages
        self._liveness = liveness
        self._attended = attended
        self._surroundings = surroundings
        self._unattended: dict[str, float] = {}  # our pending workflows without anybody, and since when
        self._next_word = 0.0
        self._next_wake = 0.0

    def give_up_lost(self) -> None:
        """Kill the stages of workflows that another worker has taken over."""
        running = self._stages.workflows()  # ahead of the query: later starts are not judged by older rows
        if running:
            for workflow in DBOS.list_workflows(workflow_ids=running, load_input=False, load_output=False):
                ours = workflow.status == "PENDING" and workflow.executor_id == self._executor
                if workflow.status in ("PENDING", "ENQUEUED") and not ours:
                    log.warning("%s now belongs to another worker", workflow.workflow_id)
                    self._stages.abandon(workflow.workflow_id)

    def take_over(self) -> bool:
        """Queue the unfinished workflows of dead workers again, and those of our own that nobody works on.

        Returns whether there may be more in a moment: some worker seems dead, but that is not certain yet.
        """
        pending: dict[str, list[str]] = {}
        for workflow in DBOS.list_workflows(status="PENDING", load_input=False, load_output=False):
            if workflow.executor_id:
                pending.setdefault(workflow.executor_id, []).append(workflow.workflow_id)
        self._resume_unattended(pending.pop(self._executor, []))
        for other, workflows in pending.items():
            with self._liveness.claim_dead(other) as dead:
                if dead:
                    log.warning("worker %s is dead; queueing %s again", other, ", ".join(workflows))
                    self._queue_again(other, workflows, "its worker died; the next free one goes on with it")
        return any(self._liveness.suspects(other) for other in pending)

    def settle(self) -> None:
        """Bring rows in line with workflows that ended without a word, because a process died at that moment."""
        jobs = {workflow_id(job.id, job.attempt): job for job in self._table.active()}
        if not jobs:
            return
        for workflow in DBOS.list_workflows(workflow_ids=list(jobs), load_input=False):
            job = jobs[workflow.workflow_id]
            if workflow.status == "CANCELLED":
                if job.time_limit and 0 < (workflow.workflow_deadline_epoch_ms or 0) <= 1000 * time.time():
                    self._table.fail(job.id, job.attempt, f"took longer than its time limit of {job.time_limit:g} s")
                else:
                    self._table.cancel(job.id, job.attempt)
            elif workflow.status == "ERROR":
                self._table.fail(job.id, job.attempt, f"internal error: {workflow.error}")
            elif workflow.status == "MAX_RECOVERY_ATTEMPTS_EXCEEDED":
                self._table.fail(
                    job.id, job.attempt, f"given up: {MAX_TAKE_OVERS} workers died while they ran this job"
                )

    def keep_alive(self) -> None:
        """Say every 20 s that this worker is there, for jobs that have nothing to report."""
        if time.monotonic() >= self._next_word:
            self._next_word = time.monotonic() + KEEP_ALIVE
            for attempt in list(self._attended):
                self._table.keep_alive(*attempt)

    def wake(self) -> None:
        """Queue the waiting jobs that this machine can run now; their pauses may be hours long."""
        if time.monotonic() < self._next_wake:
            return
        self._next_wake = time.monotonic() + WAKE
        back: dict[tuple[Cause, str], bool] = {}
        for job in self._table.waiting():
            if job.cause is None:
                continue
            seen = (job.cause, job.capture if job.cause is Cause.CAPTURE else "")
            if seen not in back:
                back[seen] = self._surroundings.is_back(job.cause, Path(job.capture))
            if back[seen]:
                # The delay first: if this process dies in between, the row waits, and a worker brings it in line.
                DBOS.set_workflow_delay(workflow_id(job.id, job.attempt), delay_seconds=0)
                if self._table.wake(job):
                    log.info("%s need not wait any more", job.id)

    def leave(self) -> None:
        """Queue this worker's jobs again at its end, once its stages have ended."""
        own = DBOS.list_workflows(status="PENDING", executor_id=self._executor, load_input=False, load_output=False)
        self._queue_again(
            self._executor,
            [workflow.workflow_id for workflow in own],
            "its worker was stopped; the next free one goes on with it",
        )

    def _resume_unattended(self, pending: list[str]) -> None:
        attended = {workflow_id(*attempt) for attempt in list(self._attended)}
        self._unattended = {
            workflow: self._unattended.get(workflow, time.monotonic())
            for workflow in pending
            if workflow not in attended
        }
        late = [name for name, since in self._unattended.items() if time.monotonic() - since >= UNATTENDED]
        for name in late:
            del self._unattended[name]
        if late:
            log.warning("nobody works on %s: queueing again", ", ".join(late))
            self._queue_again(self._executor, late, "it was interrupted; the next free worker goes on with it")

    def _queue_again(self, executor: str, workflows: list[str], reason: str) -> None:
        for workflow in workflows:
            job_id, _, attempt = workflow.rpartition(":")
            job = self._table.get(job_id)
            # Conditional: only one of those who try queues it. The next worker may have it before the row is changed.
            queued = self._dbos._sys_db.reenqueue_for_recovery(workflow, [executor], TRAINING_QUEUE)
            if queued and job is not None and job.attempt == int(attempt):
                self._table.put_back(job, reason)
