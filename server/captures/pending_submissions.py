"""Submissions being checked: a few at a time, in their own threads, and a limited number per key.

A capture is checked before it becomes a job, which takes from less than a second to minutes. The client gets an
immediate response, with a URL that later returns the job, or the reason why there is none.
"""

from __future__ import annotations

import asyncio
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

from jobs.records.job import Job
from server.http.problem_error import ProblemError

__all__ = ["PendingSubmission", "Submissions"]

MOST_OF_ONE = 16  # pending submissions per key
MOST_WAITING = 128
KEPT_SECONDS = 600.0  # time to remember the result of a submission

_AT_ONCE = 2
_MOST_KEPT = 1000


@dataclass(eq=False)
class PendingSubmission:
    """One submission: its result is `job` or `error`, and both are None until then."""

    id: str
    of: str  # id of the sender's key, "" without keys
    capture: str  # the submitted text
    wish: str  # distinguishes submissions with the same idempotency key
    running: bool = False
    job: Job | None = None
    error: Exception | None = None
    began: float = field(default_factory=time.monotonic)
    ended: float | None = None
    task: asyncio.Task[None] | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the submission object of docs/rest.md."""
        return {
            "id": self.id,
            "capture": self.capture,
            "state": "looking" if self.running else "waiting",
            "seconds": round(time.monotonic() - self.began, 1),
        }


class Submissions:
    """The submissions of one server; for its event loop."""

    def __init__(self, at_once: int = _AT_ONCE) -> None:
        """Check `at_once` captures at a time, and one per key."""
        self._threads = ThreadPoolExecutor(at_once, "submission")
        self._lanes = asyncio.Semaphore(at_once)
        self._turns: dict[str, asyncio.Semaphore] = {}
        self._all: OrderedDict[str, PendingSubmission] = OrderedDict()
        self._closed = False

    def get(self, submission_id: str) -> PendingSubmission | None:
        """Return a submission, unless it ended long ago."""
        return self._all.get(submission_id)

    def require_room(self, of: str) -> None:
        """Reject a submission that would wait too long, before any work is put into it.

        Raises:
            ProblemError: 429, this key has too many pending submissions; 503, all keys have, or the server is stopping.
        """
        under_way = [one for one in self._all.values() if one.ended is None]
        waiting = sum(one.of == of for one in under_way)
        if waiting >= MOST_OF_ONE:
            detail = f"{waiting} of your submissions are still being checked; send this one again later"
            raise ProblemError(429, "submissions-waiting", detail, headers={"Retry-After": "10"})
        if len(under_way) >= MOST_WAITING or self._closed:
            reason = (
                "the server is stopping" if self._closed else f"{len(under_way)} submissions are waiting to be checked"
            )
            detail = f"{reason}; send this one again later"
            raise ProblemError(503, "server-busy", detail, headers={"Retry-After": "30"})

    def start(self, of: str, capture: str, wish: str, work: Callable[[], Job]) -> PendingSubmission:
        """Run `work` in a thread when its turn comes.

        A pending submission with the same non-empty `wish` is returned instead.

        Raises:
            ProblemError: as `require_room`.
        """
        self._forget()
        under_way = [one for one in self._all.values() if one.ended is None]
        if wish and (same := next((one for one in under_way if (one.of, one.wish) == (of, wish)), None)):
            return same
        self.require_room(of)
        submission = PendingSubmission(secrets.token_urlsafe(16), of, capture, wish)
        self._all[submission.id] = submission
        submission.task = asyncio.create_task(self._run(submission, work))
        return submission

    async def wait(self, submission: PendingSubmission, seconds: float) -> None:
        """Wait for the end of a running submission; return at once if its turn has not come."""
        await asyncio.sleep(0)  # let it take its turn
        if submission.task is not None and submission.running:
            await asyncio.wait({submission.task}, timeout=seconds)

    async def close(self) -> None:
        """Cancel waiting submissions, and wait for the running ones, their readers have been ended."""
        self._closed = True
        tasks = [one.task for one in self._all.values() if one.task is not None and one.ended is None]
        for one in self._all.values():
            if one.task is not None and not one.running:
                one.task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        self._threads.shutdown(wait=False, cancel_futures=True)

    async def _run(self, submission: PendingSubmission, work: Callable[[], Job]) -> None:
        turn = self._turns.setdefault(submission.of, asyncio.Semaphore(1))
        try:
            async with turn, self._lanes:
                submission.running = True
                submission.job = await asyncio.get_running_loop().run_in_executor(self._threads, work)
        except asyncio.CancelledError:
            detail = "the server stopped before the capture was checked; submit it again"
            submission.error = ProblemError(503, "server-busy", detail, headers={"Retry-After": "30"})
            raise
        except Exception as error:  # reported by the next request for it
            submission.error = error
        finally:
            submission.running, submission.ended = False, time.monotonic()

    def _forget(self) -> None:
        """Drop old results."""
        now = time.monotonic()
        ended = [one for one in self._all.values() if one.ended is not None]
        for one in ended:
            if (one.ended is not None and now - one.ended > KEPT_SECONDS) or len(self._all) > _MOST_KEPT:
                del self._all[one.id]
        under_way = {one.of for one in self._all.values() if one.ended is None}
        for of in set(self._turns) - under_way:
            del self._turns[of]
