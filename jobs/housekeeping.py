"""One round of tidying a home: jobs past their time, what an interrupted removal left, chunks that no scene names."""

from __future__ import annotations

import time
from dataclasses import dataclass

from jobs.artifacts import open_store
from jobs.chunk_collection import YOUNGEST, Collection, collect_chunks
from jobs.client import JobClient, JobConflictError
from jobs.job import Job, JobState, Place
from jobs.retention import FinishedRun, Retention, folder_bytes
from jobs.run_trash import empty_trash, trash

__all__ = ["Tidied", "tidy"]

_PAGE = 1000


@dataclass(frozen=True)
class Tidied:
    """What was removed, or in a dry run would be."""

    jobs: tuple[str, ...]
    job_bytes: int  # of run folders, those that interrupted removals left included
    chunks: Collection


def tidy(client: JobClient, retention: Retention, *, delete: bool, youngest: float = YOUNGEST) -> Tidied:
    """Find, and if `delete` is given remove, what need not be kept; published scenes all stay.

    Raises:
        InputError: as `collect_chunks`; jobs are removed before.
        OSError: a run folder cannot be moved.
    """
    home = client.home
    freed = 0
    for job_id in trash(home):
        freed += folder_bytes(home.folder / "trash" / job_id)
        if delete:
            empty_trash(home, job_id)
    runs = [FinishedRun(job, folder_bytes(home.run(job.id))) for job in _finished(client)]
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
