"""The announcements of jobs' ends that are still to be sent, in the job's own database: none is lost with a process."""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from jobs.records.job_schema import job_rows, metadata

__all__ = ["Announcement", "WebhookTable", "announce"]

GIVE_UP = 3 * 86400.0  # seconds after the job's end
FIRST_PAUSE, LONGEST_PAUSE = 5.0, 3600.0  # seconds between two tries: doubled each time
LEASE = 60.0  # seconds after which another process tries, should the one that began have died

_rows = sa.Table(
    "hgs_webhook",
    metadata,
    sa.Column("job_id", sa.String(64), primary_key=True),
    sa.Column("attempt", sa.Integer, primary_key=True),
    sa.Column("url", sa.Text, nullable=False),
    sa.Column("body", sa.Text, nullable=False),
    sa.Column("ended", sa.Float(53), nullable=False),
    sa.Column("tries", sa.Integer, nullable=False),
    sa.Column("next_try", sa.Float(53), index=True),  # NULL: delivered, or given up
    sa.Column("delivered", sa.Float(53), nullable=False),  # 0: not
    sa.Column("error", sa.Text, nullable=False),
)


@dataclass(frozen=True)
class Announcement:
    """The announcement of the end of one attempt, and the state of its delivery."""

    job_id: str
    attempt: int
    url: str
    body: str
    ended: float  # seconds since the epoch
    tries: int = 0
    next_try: float | None = None  # None: delivered, or given up
    delivered: float = 0.0
    error: str = ""  # one line: why the last try failed


def announce(connection: sa.Connection, job_id: str) -> None:
    """Note, inside the transaction that finishes a job, that its end is to be told; if it asked for that."""
    query = sa.select(job_rows).where(job_rows.c.id == job_id, job_rows.c.webhook != "")
    row = connection.execute(query).one_or_none()
    if row is None:
        return
    body = {
        "type": f"job.{row.state}",
        "timestamp": row.updated,
        "data": {
            "id": row.id,
            "attempt": row.attempt,
            "state": row.state,
            "title": row.title,
            "labels": row.labels,
            "capture": row.capture,
            "scene": row.scene_id or None,
            "error": row.error or None,
        },
    }
    values = {
        "job_id": row.id,
        "attempt": row.attempt,
        "url": row.webhook,
        "body": json.dumps(body),
        "ended": row.updated,
        "tries": 0,
        "next_try": row.updated,
        "delivered": 0.0,
        "error": "",
    }
    connection.execute(sa.insert(_rows).values(values))


class WebhookTable:
    """Takes announcements out, each by one process at a time, and keeps how it went."""

    def __init__(self, engine: sa.Engine) -> None:
        self._engine = engine

    def take(self) -> Announcement | None:
        """Return an announcement that is due, which nobody else gets within a minute; or None."""
        now = time.time()
        query = sa.select(_rows).where(_rows.c.next_try <= now).order_by(_rows.c.next_try).limit(1)
        with self._engine.connect() as connection:
            row = connection.execute(query).one_or_none()
        if row is None:
            return None
        taken = self._change(row.job_id, row.attempt, row.next_try, next_try=now + LEASE)
        return Announcement(**{**row._mapping, "next_try": now + LEASE}) if taken else None

    def delivered(self, one: Announcement) -> None:
        """Note that it arrived."""
        now = time.time()
        self._change(one.job_id, one.attempt, one.next_try, next_try=None, delivered=now, tries=one.tries + 1, error="")

    def failed(self, one: Announcement, error: str, *, for_good: bool = False) -> None:
        """Note why it did not arrive; it is tried again later, for three days, unless that is no use."""
        pause = min(FIRST_PAUSE * 2.0 ** min(one.tries, 20), LONGEST_PAUSE)
        later = time.time() + pause
        give_up = for_good or later > one.ended + GIVE_UP
        self._change(
            one.job_id,
            one.attempt,
            one.next_try,
            next_try=None if give_up else later,
            tries=one.tries + 1,
            error=error,
        )

    def of(self, job_id: str) -> Announcement | None:
        """Return the last announcement of a job, or None."""
        query = sa.select(_rows).where(_rows.c.job_id == job_id).order_by(_rows.c.attempt.desc()).limit(1)
        with self._engine.connect() as connection:
            row = connection.execute(query).one_or_none()
        return None if row is None else Announcement(**row._mapping)

    def _change(self, job_id: str, attempt: int, if_next: float | None, **values: Any) -> bool:
        same = sa.and_(_rows.c.job_id == job_id, _rows.c.attempt == attempt, _rows.c.next_try == if_next)
        with self._engine.begin() as connection:
            return connection.execute(sa.update(_rows).where(same).values(values)).rowcount == 1
