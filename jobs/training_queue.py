"""The queue that every job waits in, and how an attempt gets into it."""

from __future__ import annotations

from typing import Any, cast

import sqlalchemy as sa
from dbos import DBOSClient, EnqueueOptions

from jobs.stages import STAGES

__all__ = ["MAX_PRIORITY", "TRAINING_QUEUE", "TRAIN_JOB", "enqueue", "workflow_id"]

TRAINING_QUEUE = "training"
TRAIN_JOB = "train_job"  # the name of the workflow that runs a job's stages

MAX_PRIORITY = 100  # of a job, and the least is -100: the higher is taken first

RESUMED, NEW = 1, 1000  # priorities of DBOS, of which the lower is taken first; a job's own is taken off NEW


def workflow_id(job_id: str, attempt: int) -> str:
    """Return the name of an attempt's workflow. A retry is a new workflow, so old outcomes are never rewritten."""
    return f"{job_id}:{attempt}"


def enqueue(
    queue: DBOSClient,
    connection: sa.Connection,
    job_id: str,
    attempt: int,
    *,
    delay: float = 0.0,
    waits: int = 0,
    first: str = STAGES[0],
    priority: int = 0,
    time_limit: float = 0.0,
) -> None:
    """Queue an attempt that begins with the stage `first`, inside the caller's transaction.

    With a `delay`, in seconds, it is a job that was put off: it is taken no sooner, and then before all that are new.
    `waits` counts how often in a row that has happened. Of new ones those of the highest `priority` are taken first. A
    `time_limit`, in seconds, begins when a worker takes the attempt; DBOS cancels it when that has passed.
    """
    options: dict[str, Any] = {
        "queue_name": TRAINING_QUEUE,
        "workflow_name": TRAIN_JOB,
        "workflow_id": workflow_id(job_id, attempt),
        "priority": RESUMED if delay else NEW - priority,
    }
    if delay:
        options["delay_seconds"] = delay
    if time_limit:
        options["workflow_timeout"] = time_limit  # counted from when a worker takes it
    queue.enqueue_in_transaction(connection, cast(EnqueueOptions, options), job_id, attempt, waits, first)
