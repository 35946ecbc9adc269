"""A job as its users see it: state, request, progress."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from jobs.home.passing_faults import Cause

__all__ = ["ACTIVE", "Job", "JobState", "Place"]


class JobState(StrEnum):
    """Where a job is: queued -> running -> succeeded, failed or cancelled; a retry queues it again.

    A running job that meets a fault that passes waits; it runs again by itself.
    """

    QUEUED = "queued"
    RUNNING = "running"
    WAITING = "waiting"
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    CANCELLED = "cancelled"

    @property
    def finished(self) -> bool:
        """Whether nothing more happens to the job unless it is retried."""
        return self not in ACTIVE


ACTIVE = (JobState.QUEUED, JobState.RUNNING, JobState.WAITING)  # not finished


@dataclass(frozen=True)
class Job:
    """One row of the job table. Empty strings stand for unknown values."""

    id: str
    title: str
    capture: str  # absolute path
    config: Mapping[str, Any]  # RunConfig.to_json()
    state: JobState = JobState.QUEUED
    attempt: int = 1  # counts retries, the queue's own too; every write of a worker names the attempt it belongs to
    epoch: int = 0  # counts the workers that took it: the last one's fences all earlier ones off the run's state
    stage: str = ""  # initialise, train, encode or publish
    done: int = 0  # units of the stage, out of `total`
    total: int = 0
    figures: Mapping[str, float] = field(default_factory=dict)  # e.g. loss, psnr, splats
    error: str = ""  # one line, when failed
    scene_id: str = ""  # the published scene, when succeeded
    waiting: str = ""  # one line: why an unfinished job does not go on at the moment
    cause: Cause | None = None  # the lack behind `waiting`; None if unknown
    created: float = 0.0  # seconds since the epoch
    updated: float = 0.0
    labels: tuple[str, ...] = ()  # search terms for people
    priority: int = 0  # higher ones are taken first
    time_limit: float = 0.0  # seconds that an attempt may take once a worker has taken it; 0: any
    webhook: str = ""  # the URL that is told when the job ends
    audio: str = ""  # sound, in the form of JobRequest.audio
    ends: float = 0.0  # expected end of all stages, seconds since the epoch; 0: unknown

    def to_json(self) -> dict[str, Any]:
        """Return the fields as plain JSON values."""
        return {**dataclasses.asdict(self), "state": self.state.value, "cause": self.cause or ""}


@dataclass(frozen=True)
class Place:
    """Where a job stands in the list of jobs; it moves when the job begins or ends."""

    turn: int  # 0: it runs, 1: it waits, 2: it is finished
    created: float
    job_id: str

    @classmethod
    def of(cls, job: Job) -> Place:
        """Return where the job stands."""
        return cls(0 if job.state is JobState.RUNNING else 1 + job.state.finished, job.created, job.id)
