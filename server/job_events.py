"""Jobs as JSON, and their changes as server-sent events; one task reads the queue for everybody who follows."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
from collections.abc import AsyncIterator, Iterator
from typing import TYPE_CHECKING, Any, cast
from urllib.parse import urlsplit

from starlette.concurrency import run_in_threadpool

from hgs_core.runs.config_names import by_stage
from jobs.job import Job, JobState
from jobs.worker_register import Worker
from server.encodable import encodable

if TYPE_CHECKING:
    from server.service import Jobs

__all__ = ["JobFollowers", "describe_job", "describe_worker", "job_events", "revision"]

POLL_SECONDS = 0.25
KEEP_ALIVE_SECONDS = 15.0

log = logging.getLogger("hgs.server")


def describe_job(job: Job) -> dict[str, Any]:
    """Return the job object of docs/protocol.md; what no answer could carry of it is replaced."""
    figures = {name: value for name, value in encodable(job.figures).items() if value is not None}
    progress = {"stage": job.stage, "done": job.done, "total": job.total, "figures": figures}
    config = by_stage(job.config)  # older jobs have a flat one
    description = {
        "id": job.id,
        "state": job.state.value,
        "attempt": job.attempt,
        "capture": job.capture,
        "title": job.title,
        "preset": config.get("preset"),
        "hold_out": list(config.get("capture", {}).get("hold_out", ())),
        "config": config,
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
        "stage_ends": (job.stage_ends or None) if job.state is JobState.RUNNING else None,
        "created": job.created,
        "updated": job.updated,
    }
    return cast(dict[str, Any], encodable(description))


def _origin(url: str) -> str:
    """Return the scheme and host of a URL: its path may be a secret."""
    parts = urlsplit(url)
    return f"{parts.scheme}://{parts.netloc}"


def describe_worker(worker: Worker) -> dict[str, Any]:
    """Return the worker object of docs/protocol.md."""
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


class _Follower:
    """What one follower was told last, and a bell that rings when there is more to tell, or no more."""

    def __init__(self, job: Job) -> None:
        self.job: Job | None = job
        self.bell = asyncio.Event()

    def tell(self, job: Job | None) -> None:
        """Bring news of the job, or None: it is gone, or nobody looks any more."""
        if job != self.job:
            self.job = job
            self.bell.set()


class JobFollowers:
    """Everybody who follows a job, and the task that asks the queue for all of them while there is anybody.

    A question costs one query and one thread of the pool, however many follow. A queue that does not answer is asked
    again.
    """

    def __init__(self, jobs: Jobs, stopping: asyncio.Event) -> None:
        """Follow jobs of `jobs` until `stopping` is set."""
        self._jobs = jobs
        self._stopping = stopping
        self._followers: set[_Follower] = set()
        self._asking: asyncio.Task[None] | None = None

    @contextlib.contextmanager
    def join(self, job: Job) -> Iterator[_Follower]:
        """Follow a job, from the state that the caller knows, inside the `with` block."""
        follower = _Follower(job)
        self._followers.add(follower)
        if self._asking is None or self._asking.done():
            self._asking = asyncio.create_task(self._ask())
        try:
            yield follower
        finally:
            self._followers.discard(follower)

    async def _ask(self) -> None:
        answered = True
        while not await self._stops_within(POLL_SECONDS) and self._followers:
            # Whoever joins while the queue answers may know more than the answer: those are told the next time.
            asking = [(follower.job.id, follower) for follower in self._followers if follower.job is not None]
            try:
                jobs = await run_in_threadpool(self._jobs.many, {job_id for job_id, _ in asking})
            except Exception as error:
                if answered:
                    log.warning("followers of jobs wait: the queue does not answer: %s", error)
                answered = False
                continue
            answered = True
            for job_id, follower in asking:
                follower.tell(jobs.get(job_id))
        for follower in self._followers:
            follower.tell(None)

    async def _stops_within(self, seconds: float) -> bool:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(seconds):
                await self._stopping.wait()
        return self._stopping.is_set()


async def job_events(followers: JobFollowers, job: Job) -> AsyncIterator[bytes]:
    """Yield an event now and after each change, until the job is finished, gone, or the server stops."""
    yield _event(job)
    if job.state.finished:
        return
    with followers.join(job) as follower:
        while True:
            try:  # not wait_for, which loses a cancellation that comes together with news (before Python 3.12)
                async with asyncio.timeout(KEEP_ALIVE_SECONDS):
                    await follower.bell.wait()
            except TimeoutError:
                yield b":\n\n"
                continue
            follower.bell.clear()
            if follower.job is None:
                return
            now = follower.job
            yield _event(now)
            if now.state.finished:
                return


def _event(job: Job) -> bytes:
    data = json.dumps(describe_job(job), separators=(",", ":"), ensure_ascii=False, allow_nan=False)
    return f"event: job\nid: {revision(job)}\ndata: {data}\n\n".encode()
