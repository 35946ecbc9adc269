"""Jobs as JSON, and a job's changes as server-sent events."""

from __future__ import annotations

import asyncio
import json
import math
from collections.abc import AsyncIterator
from typing import TYPE_CHECKING, Any

from starlette.concurrency import run_in_threadpool

from jobs.store import Job

if TYPE_CHECKING:
    from server.service import Jobs

__all__ = ["describe_job", "job_events", "revision"]

POLL_SECONDS = 0.25
KEEP_ALIVE_SECONDS = 15.0


def describe_job(job: Job) -> dict[str, Any]:
    """Return the job object of docs/protocol.md."""
    figures = {name: value for name, value in job.figures.items() if math.isfinite(value)}  # JSON has no NaN
    progress = {"stage": job.stage, "done": job.done, "total": job.total, "figures": figures}
    return {
        "id": job.id,
        "state": job.state.value,
        "attempt": job.attempt,
        "capture": job.capture,
        "title": job.title,
        "preset": job.config.get("preset"),
        "hold_out": list(job.config.get("hold_out", ())),
        "config": dict(job.config),
        "stage": job.stage or None,
        "progress": progress if job.stage else None,
        "error": job.error or None,
        "waiting": job.waiting or None,
        "scene": job.scene_id or None,
        "created": job.created,
        "updated": job.updated,
    }


def revision(job: Job) -> str:
    """Return the event id of the job as it is: it changes with every change of the job."""
    return f"{job.attempt}-{job.updated!r}"


async def job_events(jobs: Jobs, job: Job, stopping: asyncio.Event) -> AsyncIterator[bytes]:
    """Yield an event now and after each change, until the job is finished, gone, or the server stops."""
    yield _event(job)
    loop = asyncio.get_running_loop()
    spoken = loop.time()
    while not job.state.finished:
        try:
            await asyncio.wait_for(stopping.wait(), POLL_SECONDS)
            return
        except TimeoutError:
            pass
        now = await run_in_threadpool(jobs.get, job.id)
        if now is None:
            return
        if now != job:
            job = now
            yield _event(job)
            spoken = loop.time()
        elif loop.time() - spoken > KEEP_ALIVE_SECONDS:
            yield b":\n\n"
            spoken = loop.time()


def _event(job: Job) -> bytes:
    data = json.dumps(describe_job(job), separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return f"event: job\nid: {revision(job)}\ndata: {data}\n\n".encode()
