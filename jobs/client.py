"""What the API and the command line use of the queue: submit, look at, cancel and retry jobs."""

from __future__ import annotations

import importlib
import re
import secrets
import shutil
import unicodedata
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

from hgs_core.base.errors import InputError
from hgs_core.base.storable_text import require_storable
from jobs.database import create_engine, open_client, prepare_database
from jobs.home import Home
from jobs.store import Job, JobState, JobTable, Place, metadata
from jobs.training_queue import enqueue, workflow_id

if TYPE_CHECKING:
    from hgs_core.runs.config import RunConfig

__all__ = ["MAX_TITLE", "JobClient", "JobConflictError", "JobRequest", "readable_id"]

MAX_TITLE = 200  # characters
_MAX_PATH = 4096  # characters, as Linux


class JobConflictError(Exception):
    """The job is in a state that does not allow what was asked; the API answers 409."""


@dataclass(frozen=True)
class JobRequest:
    """A capture to train with a config. The title is for people; it defaults to the capture's name."""

    capture: Path
    config: RunConfig
    title: str = ""
    masks: Path | None = None  # a folder of masks to use instead of the capture's own

    def __post_init__(self) -> None:
        """Check what people and pages will read.

        Raises:
            InputError: the title is too long or holds control characters, or a path is no text.
        """
        require_storable("title", self.title, MAX_TITLE)
        if _one_line(self.title) != self.title:
            raise InputError("title", f"{self.title!a} holds control characters", "give one line of text")
        for where, path in (("capture", self.capture), ("masks", self.masks)):
            require_storable(where, str(path or ""), _MAX_PATH)


class JobClient:
    """A connection to the queue; it runs no job itself. Its methods block for one or two short transactions.

    Creating one creates the home and the tables where they are missing, and raises an InputError if the home's folder
    is not the one that its database belongs to. Safe to use from several threads.
    """

    def __init__(self, home: Home) -> None:
        self.home = home
        self._engine = create_engine(home)
        self._table = JobTable(self._engine)
        try:
            prepare_database(home, self._engine, metadata)
            self._queue = open_client(home, self._engine)
        except BaseException:
            self._engine.dispose()
            raise

    def submit(self, request: JobRequest) -> str:
        """Check the capture and the masks, create its run folder, queue the job and return the job's id.

        Raises:
            InputError: the capture or the config is unusable.
            OSError: the run folder cannot be written, for example because the disk is full.

        Whatever is raised, nothing stays behind.
        """
        capture = request.capture.expanduser().resolve()
        require_storable("capture", str(capture), _MAX_PATH)  # a symbolic link may lead to any name
        title = request.title.strip() or _one_line(capture.name)[:MAX_TITLE]
        job_id = readable_id(title, "job")
        run = self.home.run(job_id)
        pipeline = importlib.import_module(self.home.pipeline)
        try:
            config = pipeline.create_run(run, capture, request.config, masks=request.masks)
            job = Job(id=job_id, title=title, capture=str(capture), config=config.to_json())
            # One transaction: a job is in the table if and only if it is in the queue.
            with self._engine.begin() as connection:
                self._table.insert(connection, job)
                enqueue(self._queue, connection, job.id, job.attempt)
        except BaseException:
            shutil.rmtree(run, ignore_errors=True)
            raise
        return job_id

    def get(self, job_id: str) -> Job | None:
        """Return a job, or None if there is no such job. One indexed read: cheap enough to poll."""
        return self._table.get(job_id)

    def many(self, job_ids: Collection[str]) -> dict[str, Job]:
        """Return those of the jobs that exist, by id, with one query for every 10,000."""
        return self._table.many(job_ids)

    def list(self, limit: int = 100, state: JobState | None = None, after: Place | None = None) -> list[Job]:
        """Return a page of jobs: those that run, those that wait, those that are finished, each newest first.

        Only jobs in `state`, and only those behind the place `after`, where they are given.
        """
        return self._table.page(limit, state, after)

    def ahead_of(self, job: Job) -> int:
        """Return how many jobs were queued before a queued job, and are still: about as many are taken before it."""
        return self._table.ahead_of(job)

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
        """Queue a failed or cancelled job again; it goes on from what its run folder holds.

        Raises:
            KeyError: there is no such job.
            JobConflictError: the job is queued, running or succeeded.
        """
        job = self._known(job_id)
        with self._engine.begin() as connection:
            if not self._table.requeue(connection, job.id, job.attempt):
                raise JobConflictError(
                    f"job {job_id} is {job.state.value}; only a failed or cancelled job can be retried"
                )
            enqueue(self._queue, connection, job.id, job.attempt + 1)
        return self._known(job_id)

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

    def _known(self, job_id: str) -> Job:
        job = self.get(job_id)
        if job is None:
            raise KeyError(job_id)
        return job


def _one_line(text: str) -> str:
    """Return the text with spaces for control characters and the ends of lines and paragraphs."""
    return "".join(" " if unicodedata.category(one) in ("Cc", "Zl", "Zp") else one for one in text)


def readable_id(title: str, otherwise: str) -> str:
    """Return a unique id that is safe in URLs and file names, such as "studio-1f9c03ab", or that of `otherwise`."""
    slug = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")[:40].strip("-")
    return f"{slug or otherwise}-{secrets.token_hex(4)}"
