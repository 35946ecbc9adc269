"""The client of the queue, for the API and the command line: submit, list, cancel and retry jobs."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Callable, Collection, Sequence
from types import TracebackType
from typing import Self

import sqlalchemy as sa

from hgs_core.base.errors import InputError
from jobs.home.database import create_engine, open_client, prepare_database
from jobs.home.home import Home
from jobs.queue.edit_job import make_edit_job
from jobs.queue.edit_request import EditRequest
from jobs.queue.enqueue import enqueue, workflow_id
from jobs.queue.job_request import JobRequest
from jobs.queue.training_job import CreateRun, make_training_job
from jobs.records.announcements import Announcement, WebhookTable
from jobs.records.job import Job, JobState, Place
from jobs.records.job_filter import JobFilter
from jobs.records.job_table import JobTable, metadata
from jobs.records.worker_register import Worker, list_workers
from jobs.runs.run_places import run_place

__all__ = ["JobClient", "JobConflictError", "KeyReusedError"]


class JobConflictError(Exception):
    """The state of the job does not allow the request; the API answers 409."""


class KeyReusedError(JobConflictError):
    """Another job was asked for with this idempotency key; the API answers 422."""


class JobClient:
    """A connection to the queue; it runs no job itself. Its methods block for one or two short transactions.

    Creating one creates the home and the tables where they are missing, and raises an InputError if the home's folder
    is not the one that its database belongs to. Safe to use from several threads.
    """

    def __init__(self, home: Home, create_run: CreateRun | None = None) -> None:
        """Begin runs by `create_run`, without one in this process, as the home's pipeline does."""
        self.home = home
        self._create_run = create_run
        self._engine = create_engine(home)
        self._table = JobTable(self._engine)
        self._runs = run_place(home)
        try:
            prepare_database(home, self._engine, metadata)
            self._queue = open_client(home, self._engine)
        except BaseException:
            self._engine.dispose()
            raise

    def submit(self, request: JobRequest) -> str:
        """Check the capture and the files beside it, create its run folder, queue the job and return the job's id.

        A request with the key of an earlier one makes no second job; the id is that of the first.

        Raises:
            InputError: the capture, the sound or the config is unusable.
            KeyReusedError: the earlier request with this key asked for something else.
            OSError: the run folder cannot be written, for example because the disk is full.

        Whatever is raised, nothing stays behind.
        """
        return self._once(request, lambda: make_training_job(self.home, request, self._create_run))

    def edit(self, request: EditRequest) -> str:
        """Queue the edit of a published scene and return the job's id, which the new scene will have.

        Raises, and leaves nothing behind, as `make_edit_job`; keys hold as those of `submit`.
        """
        return self._once(request, lambda: make_edit_job(self.home, request))

    def get(self, job_id: str) -> Job | None:
        """Return a job, or None if there is no such job. One indexed read: cheap enough to poll."""
        return self._table.get(job_id)

    def many(self, job_ids: Collection[str]) -> dict[str, Job]:
        """Return those of the jobs that exist, by id, with one query for every 10,000."""
        return self._table.many(job_ids)

    def list(
        self,
        limit: int = 100,
        state: JobState | None = None,
        after: Place | None = None,
        wanted: JobFilter | None = None,
    ) -> list[Job]:
        """Return a page of jobs: those that run, those that wait, those that are finished, each newest first.

        Only jobs in `state`, only those behind the place `after`, and only those `wanted`, where they are given.
        """
        return self._table.page(limit, state, after, wanted)

    def counts(self) -> dict[str, int]:
        """Return how many jobs there are in each state."""
        return self._table.counts()

    def ahead_of(self, job: Job) -> int:
        """Return about how many jobs are taken before a queued job."""
        return self._table.ahead_of(job)

    def announcement(self, job_id: str) -> Announcement | None:
        """Return how the announcement of a job's end went, or None if there is none."""
        return WebhookTable(self._engine).of(job_id)

    def workers(self) -> Sequence[Worker]:
        """Return the workers that live, by host and age."""
        return list_workers(self._engine)

    def cancel(self, job_id: str) -> Job:
        """Cancel a job and return it as it then is; a finished job stays as it is.

        The row says cancelled at once; the processes that work on the job are gone within seconds.

        Raises:
            KeyError: there is no such job.
        """
        job = self._known(job_id)
        if not job.state.finished:
            # The workflow first: if this process dies in between, a worker brings the row in line.
            self._queue.cancel_workflow(workflow_id(job.id, job.attempt))
            self._table.cancel(job.id, job.attempt)
        return self._known(job_id)

    def retry(self, job_id: str) -> Job:
        """Queue a failed or cancelled job again, or try a waiting one now; it resumes from its run folder.

        Raises:
            KeyError: there is no such job.
            JobConflictError: the job is queued, running or succeeded.
        """
        job = self._known(job_id)
        if job.state is JobState.WAITING:
            self._queue.set_workflow_delay(workflow_id(job.id, job.attempt), delay_seconds=0)
            self._table.wake(job)
            return self._known(job_id)
        with self._engine.begin() as connection:
            if not self._table.requeue(connection, job.id, job.attempt):
                raise JobConflictError(
                    f"job {job_id} is {job.state.value}; only a failed, cancelled or waiting job can be retried"
                )
            self._enqueue(connection, job, job.attempt + 1)
        return self._known(job_id)

    def delete(self, job_id: str) -> None:
        """Forget a finished job and remove its run folder; a scene that it published stays.

        Should this process die half-way, the job is still there without its files: it can be deleted again.

        Raises:
            KeyError: there is no such job.
            JobConflictError: the job is queued or running, or its last process still saves what it has.
            OSError: the run folder cannot be moved.
        """
        job = self._known(job_id)
        if not job.state.finished:
            raise JobConflictError(f"job {job_id} is {job.state.value}; cancel it before it is deleted")
        with self._engine.begin() as connection:
            if not self._table.delete(connection, job_id):
                raise JobConflictError(f"job {job_id} was queued again; cancel it before it is deleted")
            try:
                self._runs.remove(job_id)
            except InputError as error:
                detail = f"job {job_id}: its last process still saves what it has; try again in some seconds"
                raise JobConflictError(detail) from error
        self._queue.delete_workflows([workflow_id(job_id, attempt) for attempt in range(1, job.attempt + 1)])
        self._runs.removed(job_id)

    def close(self) -> None:
        """Close the connections."""
        self._queue.destroy()
        self._engine.dispose()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()

    def _once(self, request: JobRequest | EditRequest, make: Callable[[], Job]) -> str:
        """Queue the job that `make` returns, or return the id of the one that an equal request with its key made."""
        if earlier := self._earlier(request):
            return earlier
        job = make()
        try:
            self._add(job, (request.key, request.digest) if request.key else None)
        except BaseException as error:
            self._forget(job.id)
            # Another request with this key may have arrived at the same moment.
            if isinstance(error, sa.exc.IntegrityError) and (earlier := self._earlier(request)):
                return earlier
            raise
        return job.id

    def _add(self, job: Job, request: tuple[str, str] | None = None) -> None:
        """Keep the run folder of a new job, and queue it."""
        self._runs.submitted(job.id)
        # One transaction: a job is in the table if and only if it is in the queue.
        with self._engine.begin() as connection:
            self._table.insert(connection, job, request)
            self._enqueue(connection, job, job.attempt)

    def _forget(self, job_id: str) -> None:
        """Remove the run of a job that could not be queued."""
        shutil.rmtree(self.home.run(job_id), ignore_errors=True)
        with contextlib.suppress(Exception):  # `hgs gc` removes what cannot be removed now
            self._runs.remove(job_id)

    def _earlier(self, request: JobRequest | EditRequest) -> str:
        """Return the job that an earlier request with the same key made; "" if there is none."""
        found = self._table.requested(request.key) if request.key else None
        if found is None:
            return ""
        job_id, digest = found
        if digest != request.digest:
            raise KeyReusedError(f"the key {request.key!a} was given before, with another request (job {job_id})")
        return job_id

    def _enqueue(self, connection: sa.Connection, job: Job, attempt: int) -> None:
        enqueue(self._queue, connection, job.id, attempt, priority=job.priority, time_limit=job.time_limit)

    def _known(self, job_id: str) -> Job:
        job = self.get(job_id)
        if job is None:
            raise KeyError(job_id)
        return job
