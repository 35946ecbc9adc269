"""What was submitted and is being looked at: a few at a time, in threads of their own, and only so many of one key.

A capture is looked at before a job is made of it, which takes from less than a second to minutes. Whoever submits it
gets an answer at once, with an address where the job, or why there is none, can be asked for.
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

MOST_OF_ONE = 16  # that one key may have waiting
MOST_WAITING = 128
KEPT_SECONDS = 600.0  # for which the end of a submission can be asked for

_AT_ONCE = 2
_MOST_KEPT = 1000


@dataclass(eq=False)
class PendingSubmission:
    """One submission: `job` is what was made of it, `error` why there is none, and before both are None."""

    id: str
    of: str  # who sent it: the id of a key, "" for all who need none
    capture: str  # as it was named
    wish: str  # what tells it from others with the same idempotency key
    running: bool = False
    job: Job | None = None
    error: Exception | None = None
    began: float = field(default_factory=time.monotonic)
    ended: float | None = None
    task: asyncio.Task[None] | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the submission object of docs/protocol.md."""
        return {
            "id": self.id,
            "capture": self.capture,
            "state": "looking" if self.running else "waiting",
            "seconds": round(time.monotonic() - self.began, 1),
        }


class Submissions:
    """The submissions of one server; used from its event loop alone."""

    def __init__(self, at_once: int = _AT_ONCE) -> None:
        """Look at `at_once` captures at a time, and at one of each key."""
        self._threads = ThreadPoolExecutor(at_once, "submission")
        self._lanes = asyncio.Semaphore(at_once)
        self._turns: dict[str, asyncio.Semaphore] = {}
        self._all: OrderedDict[str, PendingSubmission] = OrderedDict()
        self._closed = False

    def get(self, submission_id: str) -> PendingSubmission | None:
        """Return a submission, unless it ended long ago."""
        return self._all.get(submission_id)

    def require_room(self, of: str) -> None:
        """Refuse what is not looked at for long, before any work is put into it.

        Raises:
            ProblemError: 429, this key has too many that wait; 503, all together have, or the server stops.
        """
        under_way = [one for one in self._all.values() if one.ended is None]
        waiting = sum(one.of == of for one in under_way)
        if waiting >= MOST_OF_ONE:
            detail = f"{waiting} submissions of yours are being looked at already; send this one again later"
            raise ProblemError(429, "submissions-waiting", detail, headers={"Retry-After": "10"})
        if len(under_way) >= MOST_WAITING or self._closed:
            reason = "the server stops" if self._closed else f"{len(under_way)} submissions wait to be looked at"
            detail = f"{reason}; send this one again later"
            raise ProblemError(503, "server-busy", detail, headers={"Retry-After": "30"})

    def start(self, of: str, capture: str, wish: str, work: Callable[[], Job]) -> PendingSubmission:
        """Have `work` done, in a thread, when it is its turn.

        A submission that is under way for the same `wish`, which is not "", is returned instead.

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
        """Wait for the end of a submission that is being looked at; one whose turn has not come is not waited for."""
        await asyncio.sleep(0)  # let it take its turn
        if submission.task is not None and submission.running:
            await asyncio.wait({submission.task}, timeout=seconds)

    async def close(self) -> None:
        """Give up what waits, and wait for what runs; its readers have been ended."""
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
            detail = "the server stopped before it was looked at; send it again"
            submission.error = ProblemError(503, "server-busy", detail, headers={"Retry-After": "30"})
            raise
        except Exception as error:  # whoever asks gets it
            submission.error = error
        finally:
            submission.running, submission.ended = False, time.monotonic()

    def _forget(self) -> None:
        """Keep no more than what runs, and what has ended lately."""
        now = time.monotonic()
        ended = [one for one in self._all.values() if one.ended is not None]
        for one in ended:
            if (one.ended is not None and now - one.ended > KEPT_SECONDS) or len(self._all) > _MOST_KEPT:
                del self._all[one.id]
        under_way = {one.of for one in self._all.values() if one.ended is None}
        for of in set(self._turns) - under_way:
            del self._turns[of]
