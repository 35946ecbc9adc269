"""The job table, in the same database as the queue."""

from __future__ import annotations

import time
from collections.abc import Collection
from typing import Any

import sqlalchemy as sa

from hgs_core.base.progress import Progress
from jobs.home.passing_faults import Cause
from jobs.records.announcements import announce
from jobs.records.job import ACTIVE, Job, JobState, Place
from jobs.records.job_filter import JobFilter
from jobs.records.job_schema import job_labels, job_rows, metadata

__all__ = ["JobTable", "metadata"]

JOB_SILENCE = 60.0  # seconds without a word from a worker, which speaks every 20 s, after which a running job says so
_MOST_IDS = 10_000  # ids of one query; SQLite allows 32,766 values, Postgres 65,535


class JobTable:
    """Reads and writes of the job table.

    Every change is one conditional UPDATE, so that whoever comes second (a cancel, a worker that was given up for dead,
    the retry of an old attempt) changes nothing; the methods then return False.
    """

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine

    def insert(self, connection: sa.Connection, job: Job, request: tuple[str, str] | None = None) -> None:
        """Add a row inside the caller's transaction; `request` is the key and the digest of the request.

        Raises:
            sqlalchemy.exc.IntegrityError: another job has this key.
        """
        row = job.to_json()
        row["created"] = row["updated"] = time.time()
        if request is not None:
            row["request_key"], row["request_digest"] = request
        connection.execute(sa.insert(job_rows).values(row))
        if job.labels:
            labels = [{"label": label, "job_id": job.id} for label in job.labels]
            connection.execute(sa.insert(job_labels), labels)

    def requested(self, key: str) -> tuple[str, str] | None:
        """Return the id of the job requested with this key, and the digest of the request; or None."""
        query = sa.select(job_rows.c.id, job_rows.c.request_digest).where(job_rows.c.request_key == key)
        with self._engine.connect() as connection:
            row = connection.execute(query).one_or_none()
        return None if row is None else (row.id, row.request_digest)

    def delete(self, connection: sa.Connection, job_id: str) -> bool:
        """Remove the row of a finished job, inside the caller's transaction."""
        finished = job_rows.c.state.not_in(ACTIVE)
        if connection.execute(sa.delete(job_rows).where(job_rows.c.id == job_id, finished)).rowcount != 1:
            return False
        connection.execute(sa.delete(job_labels).where(job_labels.c.job_id == job_id))
        return True

    def get(self, job_id: str) -> Job | None:
        """Return a job, or None if there is no such job."""
        with self._engine.connect() as connection:
            row = connection.execute(sa.select(job_rows).where(job_rows.c.id == job_id)).one_or_none()
        return None if row is None else _job(row)

    def many(self, job_ids: Collection[str]) -> dict[str, Job]:
        """Return those of the jobs that exist, by id, with one query for every 10,000."""
        ids, jobs = list(job_ids), {}
        with self._engine.connect() as connection:
            for start in range(0, len(ids), _MOST_IDS):
                query = sa.select(job_rows).where(job_rows.c.id.in_(ids[start : start + _MOST_IDS]))
                jobs.update({row.id: _job(row) for row in connection.execute(query)})
        return jobs

    def page(
        self, limit: int, state: JobState | None = None, after: Place | None = None, wanted: JobFilter | None = None
    ) -> list[Job]:
        """Return at most `limit` jobs: those that run, those that wait, those that are finished, each newest first.

        Only jobs in `state`, only those behind the place `after`, and only those `wanted`, where they are given.
        """
        turn = sa.case((job_rows.c.state == JobState.RUNNING, 0), (job_rows.c.state.in_(ACTIVE), 1), else_=2)
        order = (turn, job_rows.c.created.desc(), job_rows.c.id)
        query = sa.select(job_rows.c.id).order_by(*order).limit(limit)
        if state is not None:
            query = query.where(job_rows.c.state == state)
        if after is not None:
            same = sa.and_(job_rows.c.created == after.created, job_rows.c.id > after.job_id)
            behind = sa.and_(turn == after.turn, sa.or_(job_rows.c.created < after.created, same))
            query = query.where(sa.or_(turn > after.turn, behind))
        if wanted is not None:
            query = query.where(*wanted.conditions())
        # All jobs are sorted, so without their configs; those of the page alone are then read whole.
        whole = sa.select(job_rows).where(job_rows.c.id.in_(query)).order_by(*order)
        with self._engine.connect() as connection:
            return [_job(row) for row in connection.execute(whole)]

    def counts(self) -> dict[str, int]:
        """Return how many jobs there are in each state, 0 included."""
        query = sa.select(job_rows.c.state, sa.func.count()).group_by(job_rows.c.state)
        with self._engine.connect() as connection:
            found = {row[0]: int(row[1]) for row in connection.execute(query)}
        return {state.value: found.get(state.value, 0) for state in JobState}

    def ahead_of(self, job: Job) -> int:
        """Return how many queued jobs have a higher priority, or the same and were queued before: about as many are
        taken before it.
        """
        before = sa.and_(job_rows.c.priority == job.priority, job_rows.c.updated < job.updated)
        query = sa.select(sa.func.count()).select_from(job_rows).where(job_rows.c.state == JobState.QUEUED)
        query = query.where(sa.or_(job_rows.c.priority > job.priority, before), job_rows.c.id != job.id)
        with self._engine.connect() as connection:
            return connection.execute(query).scalar_one()

    def active(self) -> list[Job]:
        """Return the jobs that are not finished."""
        return self._where(job_rows.c.state.in_(ACTIVE))

    def waiting(self) -> list[Job]:
        """Return the jobs that wait for something which can be looked for, their `cause`."""
        return self._where(job_rows.c.state == JobState.WAITING, job_rows.c.cause != "")

    def _where(self, *conditions: sa.ColumnElement[bool]) -> list[Job]:
        with self._engine.connect() as connection:
            return [_job(row) for row in connection.execute(sa.select(job_rows).where(*conditions))]

    def start(self, job_id: str, attempt: int) -> int:
        """Mark an attempt as running, also when a worker takes it over, and return the job's next epoch, 1 or more.

        Returns 0, and changes nothing, once the attempt is finished or followed by another.
        """
        statement = _unfinished(job_id, attempt).values(
            state=JobState.RUNNING, waiting="", cause="", epoch=job_rows.c.epoch + 1, updated=time.time()
        )
        with self._engine.begin() as connection:
            epoch = connection.execute(statement.returning(job_rows.c.epoch)).scalar_one_or_none()
        return 0 if epoch is None else int(epoch)

    def keep_alive(self, job_id: str, attempt: int) -> bool:
        """Renew the date of a running attempt that has nothing to report."""
        return self._update(job_id, attempt)

    def put_back(self, job: Job, reason: str) -> bool:
        """Mark an attempt as queued again, because its worker works on it no more; not if its row has changed since."""
        return self._update(job.id, job.attempt, if_updated=job.updated, state=JobState.QUEUED, waiting=reason)

    def wake(self, job: Job) -> bool:
        """Mark a waiting attempt as queued: it is tried again as soon as a worker is free."""
        return self._update(job.id, job.attempt, if_updated=job.updated, state=JobState.QUEUED, waiting="", cause="")

    def progress(self, job_id: str, attempt: int, progress: Progress, ends: float = 0.0) -> bool:
        """Record how far a running attempt is, and when the job will probably end."""
        return self._update(
            job_id,
            attempt,
            stage=progress.stage,
            done=progress.done,
            total=progress.total,
            figures=dict(progress.figures),
            ends=ends,
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
            sa.update(job_rows)
            .where(job_rows.c.id == job_id, job_rows.c.attempt == attempt)
            .where(job_rows.c.state.in_((JobState.FAILED, JobState.CANCELLED)))
            .values(state=JobState.QUEUED, attempt=attempt + 1, stage="", done=0, total=0, error="", waiting="")
            .values(updated=time.time())
        )
        return connection.execute(statement).rowcount == 1

    def put_off(
        self, connection: sa.Connection, job_id: str, attempt: int, reason: str, cause: Cause | None = None
    ) -> bool:
        """Turn an unfinished attempt into the next one, which waits, inside the caller's transaction.

        It keeps its progress. `cause` is what to look for; None if unknown.
        """
        values: dict[str, Any] = {"state": JobState.WAITING, "attempt": attempt + 1, "updated": time.time()}
        values |= {"waiting": reason, "cause": "" if cause is None else cause.value}
        return connection.execute(_unfinished(job_id, attempt).values(values)).rowcount == 1

    def _update(self, job_id: str, attempt: int, *, if_updated: float | None = None, **values: Any) -> bool:
        statement = _unfinished(job_id, attempt).values(updated=time.time(), **values)
        if if_updated is not None:
            statement = statement.where(job_rows.c.updated == if_updated)
        with self._engine.begin() as connection:
            changed = connection.execute(statement).rowcount == 1
            if changed and "state" in values and values["state"].finished:
                announce(connection, job_id)
            return changed


def _unfinished(job_id: str, attempt: int) -> sa.Update:
    """Return the change of an attempt's row that does nothing once the attempt is finished or followed by another."""
    return sa.update(job_rows).where(
        job_rows.c.id == job_id, job_rows.c.attempt == attempt, job_rows.c.state.in_(ACTIVE)
    )


def _job(row: sa.Row[Any]) -> Job:
    values = {name: value for name, value in row._mapping.items() if not name.startswith("request_")}
    values["state"], values["labels"] = JobState(values["state"]), tuple(values["labels"])
    values["cause"] = Cause(values["cause"]) if values["cause"] else None
    silence = time.time() - values["updated"]
    if values["state"] is JobState.RUNNING and silence > JOB_SILENCE:
        values["waiting"] = f"no worker has reported on it for {silence / 60:.0f} min"
    return Job(**values)
