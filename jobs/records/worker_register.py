"""The register of workers and their activity: for people, not for decisions of the queue.

`python -m jobs.records.worker_register` is the health check of a container: is there a worker on this host that speaks?
Whether a worker is dead is told by its lock (`jobs.queue.liveness`).
"""

from __future__ import annotations

import os
import socket
import sys
import time
from dataclasses import dataclass

import sqlalchemy as sa

from jobs.home.database import create_engine
from jobs.home.home import Home
from jobs.records.job_schema import worker_rows

__all__ = ["Worker", "WorkerRegister", "list_workers", "main"]

INTERVAL = 10.0  # seconds between two words of a worker with nothing new to say
WORKER_SILENCE = 60.0  # seconds without a word after which a worker is not counted
FORGOTTEN = 86400.0  # seconds after which the row of one that died is removed


@dataclass(frozen=True)
class Worker:
    """A worker that lives, or did a minute ago. It has one slot: it runs one job at a time."""

    id: str
    host: str
    pid: int
    device: str  # CUDA_VISIBLE_DEVICES, where that is set
    job_id: str  # its current job; "" while idle
    idle_because: str  # one line: why it takes no job at the moment; empty if it would
    started: float  # seconds since the epoch
    seen: float


class WorkerRegister:
    """The entry of one worker."""

    def __init__(self, engine: sa.Engine, executor: str) -> None:
        """Speak as `executor`."""
        self._engine = engine
        self._id = executor
        self._said: tuple[str, str] | None = None
        self._next = 0.0

    def tell(self, job_id: str, idle_because: str) -> None:
        """Write the worker's activity; within 10 s only if it has changed."""
        if self._said == (job_id, idle_because) and time.monotonic() < self._next:
            return
        now = time.time()
        doing = {"job_id": job_id, "idle_because": idle_because, "seen": now}
        with self._engine.begin() as connection:
            known = sa.update(worker_rows).where(worker_rows.c.id == self._id).values(doing)
            if not connection.execute(known).rowcount:
                row = {
                    "id": self._id,
                    "host": socket.gethostname(),
                    "pid": os.getpid(),
                    "started": now,
                    "device": os.environ.get("CUDA_VISIBLE_DEVICES", ""),
                    **doing,
                }
                connection.execute(sa.insert(worker_rows).values(row))
                connection.execute(sa.delete(worker_rows).where(worker_rows.c.seen < now - FORGOTTEN))
        self._said, self._next = (job_id, idle_because), time.monotonic() + INTERVAL

    def leave(self) -> None:
        """Be there no more."""
        with self._engine.begin() as connection:
            connection.execute(sa.delete(worker_rows).where(worker_rows.c.id == self._id))


def list_workers(engine: sa.Engine) -> list[Worker]:
    """Return the workers that have spoken within the last minute, by host and age."""
    query = sa.select(worker_rows).where(worker_rows.c.seen >= time.time() - WORKER_SILENCE)
    with engine.connect() as connection:
        rows = connection.execute(query.order_by(worker_rows.c.host, worker_rows.c.started, worker_rows.c.id))
        return [Worker(**row._mapping) for row in rows]


def main() -> None:
    """End with status 0 if a worker on this host has spoken within the last minute, else with one line and 1."""
    host = socket.gethostname()
    engine = create_engine(Home.from_environment())
    if not any(worker.host == host for worker in list_workers(engine)):
        sys.exit(f"no worker on {host} has spoken within {WORKER_SILENCE:g} s")


if __name__ == "__main__":
    main()
