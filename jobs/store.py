"""The job table: what a user sees of a job, in the same database as the queue."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import sqlalchemy as sa

from hgs_core.progress import Progress

__all__ = ["Job", "JobState", "JobTable", "metadata"]

metadata = sa.MetaData()

_jobs = sa.Table(
    "hgs_job",
    metadata,
    sa.Column("id", sa.String(64), primary_key=True),
    sa.Column("title", sa.Text, nullable=False),
    sa.Column("capture", sa.Text, nullable=False),
    sa.Column("config", sa.JSON, nullable=False),
    sa.Column("state", sa.String(16), nullable=False, index=True),
    sa.Column("attempt", sa.Integer, nullable=False),
    sa.Column("stage", sa.String(32), nullable=False),
    sa.Column("done", sa.BigInteger, nullable=False),
    sa.Column("total", sa.BigInteger, nullable=False),
    sa.Column("figures", sa.JSON, nullable=False),
    sa.Column("error", sa.Text, nullable=False),
    sa.Column("scene_id", sa.String(64), nullable=False),
    sa.Column("waiting", sa.Text, nullable=False, server_default=""),
    sa.Column("created", sa.Float(53), nullable=False, index=True),
    sa.Column("updated", sa.Float(53), nullable=False),
)

SILENCE = 60.0  # seconds without a word from a worker, which speaks every 20 s, after which a running job says so


class JobState(StrEnum):
    """Where a job is: queued -> running -> succeeded, failed or cancelled; a retry queues it again."""

    QUEUED = "queued"
    RUNNING = "running"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def finished(self) -> bool:
        """Whether nothing more happens to the job unless it is retried."""
        return self not in _ACTIVE


_ACTIVE = (JobState.QUEUED, JobState.RUNNING)


@dataclass(frozen=True)
class Job:
    """One row of the job table. Empty strings stand for what is not known (yet)."""

    id: str
    title: str
    capture: str  # absolute path
    config: Mapping[str, Any]  # TrainConfig.to_json()
    state: JobState = JobState.QUEUED
    attempt: int = 1  # counts retries, the queue's own too; every write of a worker names the attempt it belongs to
    stage: str = ""  # initialise, train, encode or publish
    done: int = 0  # of `total` units of the stage
    total: int = 0
    figures: Mapping[str, float] = field(default_factory=dict)  # e.g. loss, psnr, splats
    error: str = ""  # one line, when failed
    scene_id: str = ""  # the published scene, when succeeded
    waiting: str = ""  # one line: why a queued or running job does not go on at the moment
    created: float = 0.0  # seconds since the epoch
    updated: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """Return the fields as plain JSON values."""
        return {**dataclasses.asdict(self), "state": self.state.value}


class JobTable:
    """Reads and writes of the job table.

    Every change is one conditional UPDATE, so that whoever comes second (a cancel, a worker that was given up for dead,
    the retry of an old attempt) changes nothing; the methods then return False.
    """

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine

    def insert(self, connection: sa.Connection, job: Job) -> None:
        """Add a row inside the caller's transaction."""
        row = job.to_json()
        row["created"] = row["updated"] = time.time()
        connection.execute(sa.insert(_jobs).values(row))

    def get(self, job_id: str) -> Job | None:
        """Return a job, or None if there is no such job."""
        with self._engine.connect() as connection:
            row = connection.execute(sa.select(_jobs).where(_jobs.c.id == job_id)).one_or_none()
        return None if row is None else _job(row)

    def newest(self, limit: int) -> list[Job]:
        """Return the newest `limit` jobs, newest first."""
        query = sa.select(_jobs).order_by(_jobs.c.created.desc(), _jobs.c.id).limit(limit)
        with self._engine.connect() as connection:
            return [_job(row) for row in connection.execute(query)]

    def active(self) -> list[Job]:
        """Return the jobs that are queued or running."""
        query = sa.select(_jobs).where(_jobs.c.state.in_(_ACTIVE))
        with self._engine.connect() as connection:
            return [_job(row) for row in connection.execute(query)]

    def start(self, job_id: str, attempt: int) -> bool:
        """Mark an attempt as running; also when a worker takes it over."""
        return self._update(job_id, attempt, state=JobState.RUNNING, waiting="")

    def keep_alive(self, job_id: str, attempt: int) -> bool:
        """Renew the date of a running attempt that has nothing to report."""
        return self._update(job_id, attempt)

    def put_back(self, job: Job, reason: str) -> bool:
        """Mark an attempt as queued again, because its worker works on it no more; not if its row has changed since."""
        return self._update(job.id, job.attempt, if_updated=job.updated, state=JobState.QUEUED, waiting=reason)

    def progress(self, job_id: str, attempt: int, progress: Progress) -> bool:
        """Record how far a running attempt is."""
        return self._update(
            job_id,
            attempt,
            stage=progress.stage,
            done=progress.done,
            total=progress.total,
            figures=dict(progress.figures),
        )

    def succeed(self, job_id: str, attempt: int, scene_id: str) -> bool:
        """Mark an attempt as succeeded."""
        return self._update(job_id, attempt, state=JobState.SUCCEEDED, scene_id=scene_id, waiting="")

    def fail(self, job_id: str, attempt: int, error: str) -> bool:
        """Mark an attempt as failed with a one-line error."""
        return self._update(job_id, attempt, state=JobState.FAILED, error=error, waiting="")

    def cancel(self, job_id: str, attempt: int) -> bool:
        """Mark an attempt as cancelled."""
        return self._update(job_id, attempt, state=JobState.CANCELLED, waiting="")

    def requeue(self, connection: sa.Connection, job_id: str, attempt: int) -> bool:
        """Turn a failed or cancelled attempt into the next one, inside the caller's transaction."""
        statement = (
            sa.update(_jobs)
            .where(_jobs.c.id == job_id, _jobs.c.attempt == attempt)
            .where(_jobs.c.state.in_((JobState.FAILED, JobState.CANCELLED)))
            .values(state=JobState.QUEUED, attempt=attempt + 1, stage="", done=0, total=0, error="", waiting="")
            .values(updated=time.time())
        )
        return connection.execute(statement).rowcount == 1

    def put_off(self, connection: sa.Connection, job_id: str, attempt: int, reason: str) -> bool:
        """Turn an unfinished attempt into the next one, inside the caller's transaction; it keeps its progress."""
        values = {"state": JobState.QUEUED, "attempt": attempt + 1, "waiting": reason, "updated": time.time()}
        return connection.execute(_unfinished(job_id, attempt).values(values)).rowcount == 1

    def _update(self, job_id: str, attempt: int, *, if_updated: float | None = None, **values: Any) -> bool:
        statement = _unfinished(job_id, attempt).values(updated=time.time(), **values)
        if if_updated is not None:
            statement = statement.where(_jobs.c.updated == if_updated)
        with self._engine.begin() as connection:
            return connection.execute(statement).rowcount == 1


def _unfinished(job_id: str, attempt: int) -> sa.Update:
    """Return the change of an attempt's row that does nothing once the attempt is finished or followed by another."""
    return sa.update(_jobs).where(_jobs.c.id == job_id, _jobs.c.attempt == attempt, _jobs.c.state.in_(_ACTIVE))


def _job(row: sa.Row[Any]) -> Job:
    values = dict(row._mapping)
    values["state"] = JobState(values["state"])
    silence = time.time() - values["updated"]
    if values["state"] is JobState.RUNNING and silence > SILENCE:
        values["waiting"] = f"no worker has reported on it for {silence / 60:.0f} min"
    return Job(**values)
