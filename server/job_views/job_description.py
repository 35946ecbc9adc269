"""JSON descriptions of jobs and workers, as documented for the API."""

from __future__ import annotations

from typing import Any, cast
from urllib.parse import urlsplit

from jobs.records.job import Job, JobState
from jobs.records.worker_register import Worker
from server.http.encodable import encodable

__all__ = ["describe_job", "describe_worker", "revision"]


def describe_job(job: Job) -> dict[str, Any]:
    """Return the job object of docs/rest.md, with replacements for values that JSON cannot hold."""
    figures = {name: value for name, value in encodable(job.figures).items() if value is not None}
    progress = {"stage": job.stage, "done": job.done, "total": job.total, "figures": figures}
    description = {
        "id": job.id,
        "state": job.state.value,
        "attempt": job.attempt,
        "capture": job.capture,
        "title": job.title,
        "preset": job.config.get("preset"),
        "hold_out": list(job.config.get("capture", {}).get("hold_out", ())),
        "config": job.config,
        "audio": job.audio or None,
        "stage": job.stage or None,
        "progress": progress if job.stage else None,
        "error": job.error or None,
        "waiting": job.waiting or None,
        "scene": job.scene_id or None,
        "labels": list(job.labels),
        "priority": job.priority,
        "time_limit": job.time_limit or None,
        "webhook": _origin(job.webhook) if job.webhook else None,
        "ends": (job.ends or None) if job.state is JobState.RUNNING else None,
        "created": job.created,
        "updated": job.updated,
    }
    return cast(dict[str, Any], encodable(description))


def _origin(url: str) -> str:
    """Return the scheme and host of a URL: its path may be a secret."""
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.netloc}"


def describe_worker(worker: Worker) -> dict[str, Any]:
    """Return the worker object of docs/rest.md."""
    return {
        "id": worker.id,
        "host": worker.host,
        "pid": worker.pid,
        "device": worker.device or None,
        "job": worker.job_id or None,
        "idle_because": worker.idle_because or None,
        "started": worker.started,
        "seen": worker.seen,
    }


def revision(job: Job) -> str:
    """Return the event id of the job as it is: it changes with every change of the job."""
    return f"{job.attempt}-{job.updated!r}"
