"""The queue that every job waits in, and how an attempt gets into it."""

from __future__ import annotations

from typing import Any, cast

import sqlalchemy as sa
from dbos import DBOSClient, EnqueueOptions

from jobs.home.stage_settings import STAGES

__all__ = [
    "HELP_JOB",
    "MAX_PRIORITY",
    "TRAINING_QUEUE",
    "TRAIN_JOB",
    "ask_for_help",
    "enqueue",
    "helper_name",
    "job_of",
    "workflow_id",
]

TRAINING_QUEUE = "training"
TRAIN_JOB = "train_job"  # the name of the workflow that runs a job's stages
HELP_JOB = "help_job"  # and of the one that makes a segment of a job that another worker has

MAX_PRIORITY = 100  # the least is -100; the higher is taken first

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


def helper_name(job_id: str, number: int) -> str:
    """Return the name under which the helper with this number works on a job; no job has it."""
    return f"{job_id}#{number}"


def job_of(name: str) -> str:
    """Return the job of a helper's name, or of a job's own."""
    return name.partition("#")[0]


def ask_for_help(
    queue: DBOSClient, connection: sa.Connection, job_id: str, attempt: int, helpers: int, priority: int = 0
) -> None:
    """Queue so many helpers of an attempt, each for one segment, as jobs of that `priority` are.

    Those that are there already stay as they are.
    """
    for number in range(1, helpers + 1):
        options: dict[str, Any] = {
            "queue_name": TRAINING_QUEUE,
            "workflow_name": HELP_JOB,
            "workflow_id": workflow_id(helper_name(job_id, number), attempt),
            "priority": NEW - priority,
        }
        queue.enqueue_in_transaction(connection, cast(EnqueueOptions, options), job_id, number, attempt)
