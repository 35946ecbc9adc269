"""Followers of jobs: server-sent events, and one task that polls the queue for all of them."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
from collections.abc import AsyncIterator, Iterator

from starlette.concurrency import run_in_threadpool

from jobs.records.job import Job
from server.job_views.job_description import describe_job, revision
from server.parts import Jobs

__all__ = ["JobFollowers", "job_events"]

POLL_SECONDS = 0.25
KEEP_ALIVE_SECONDS = 15.0

log = logging.getLogger("hgs.server")


class _Follower:
    """State last sent to a follower, and an event set when it changes or ends."""

    def __init__(self, job: Job) -> None:
        self.job: Job | None = job
        self.bell = asyncio.Event()

    def tell(self, job: Job | None) -> None:
        """Set the job's new state, or None if the job is gone or polling has ended."""
        if job != self.job:
            self.job = job
            self.bell.set()


class JobFollowers:
    """All followers of jobs, and the task that polls the queue while there are any.

    A poll costs one query and one thread of the pool for any number of followers. A failed poll is repeated.
    """

    def __init__(self, jobs: Jobs, stopping: asyncio.Event) -> None:
        """Follow jobs of `jobs` until `stopping` is set."""
        self._jobs = jobs
        self._stopping = stopping
        self._followers: set[_Follower] = set()
        self._asking: asyncio.Task[None] | None = None

    @contextlib.contextmanager
    def join(self, job: Job) -> Iterator[_Follower]:
        """Follow a job inside the `with` block, from the state known to the caller."""
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
            # A follower that joins while the queue responds may be newer than the response, and waits for the next one.
            asking = [(follower.job.id, follower) for follower in self._followers if follower.job is not None]
            try:
                jobs = await run_in_threadpool(self._jobs.many, {job_id for job_id, _ in asking})
            except Exception as error:
                if answered:
                    log.warning("followers of jobs are waiting: the job queue does not respond: %s", error)
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
    """Yield an event now and after each change, until the job is finished or gone, or the server stops."""
    yield _event(job)
    if job.state.finished:
        return
    with followers.join(job) as follower:
        while True:
            # wait_for loses a cancellation that arrives together with the event (before Python 3.12).
            try:
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
