"""One round of tidying a home: jobs past their time, remains of interrupted removals, chunks that no scene names."""

from __future__ import annotations

import time
from dataclasses import dataclass

from jobs.artifacts.artifact_store import open_store
from jobs.artifacts.chunk_collection import YOUNGEST, Collection, collect_chunks
from jobs.queue.client import JobClient, JobConflictError
from jobs.records.job import Job, JobState, Place
from jobs.runs.retention import FinishedRun, Retention
from jobs.runs.run_places import run_place

__all__ = ["Tidied", "tidy"]

_PAGE = 1000


@dataclass(frozen=True)
class Tidied:
    """The removed jobs and bytes; in a dry run those to remove."""

    jobs: tuple[str, ...]
    job_bytes: int  # bytes of run folders, remains of interrupted removals included
    chunks: Collection


def tidy(client: JobClient, retention: Retention, *, delete: bool, youngest: float = YOUNGEST) -> Tidied:
    """Find, and if `delete` is given remove, everything past its retention; published scenes all stay.

    Raises:
        InputError: as `collect_chunks`; jobs are removed before.
        OSError: a run folder cannot be moved.
    """
    home, place = client.home, run_place(client.home)
    finished = _finished(client)
    freed = place.left_over(client.many, delete=delete)
    sizes = place.sizes([job.id for job in finished])
    runs = [FinishedRun(job, sizes[job.id]) for job in finished]
    removed: list[str] = []
    for run in retention.expired(runs, time.time()):
        if delete:
            try:
                client.delete(run.job.id)
            except (JobConflictError, KeyError):  # queued again, or deleted by somebody else
                continue
        removed.append(run.job.id)
        freed += run.bytes
    return Tidied(tuple(removed), freed, collect_chunks(open_store(home), delete=delete, youngest=youngest))


def _finished(client: JobClient) -> list[Job]:
    found: list[Job] = []
    for state in JobState:
        page: list[Job] = []
        while state.finished and (page := client.list(_PAGE, state, Place.of(page[-1]) if page else None)):
            found += page
    return found
