"""Jobs as JSON."""

from __future__ import annotations

from typing import Any

from jobs.store import Job
from server.encodable import encodable

__all__ = ["describe_job", "revision"]


def describe_job(job: Job) -> dict[str, Any]:
    """Return the job object of docs/protocol.md."""
    figures = {name: value for name, value in encodable(job.figures).items() if value is not None}
    progress = {"stage": job.stage, "done": job.done, "total": job.total, "figures": figures}
    description: dict[str, Any] = encodable(
        {
            "id": job.id,
            "state": job.state.value,
            "attempt": job.attempt,
            "capture": job.capture,
            "title": job.title,
            "preset": job.config.get("preset"),
            "hold_out": job.config.get("hold_out", ()),
            "config": job.config,
            "stage": job.stage or None,
            "progress": progress if job.stage else None,
            "error": job.error or None,
            "scene": job.scene_id or None,
            "created": job.created,
            "updated": job.updated,
        }
    )
    return description


def revision(job: Job) -> str:
    """Return the event id of the job as it is: it changes with every change of the job."""
    return f"{job.attempt}-{job.updated!r}"
