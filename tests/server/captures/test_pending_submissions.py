from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable

import pytest

from hgs_core.base.errors import InputError
from jobs.records.job import Job
from server.captures import pending_submissions as module
from server.captures.pending_submissions import PendingSubmission, Submissions
from server.http.problem_error import ProblemError

JOB = Job("studio-1", "Studio", "/captures/studio", {}, created=1.0, updated=1.0)


class Looks:
    """Work that waits until it is let go, and counts how much of it runs at once."""

    def __init__(self) -> None:
        self.go = threading.Event()
        self.running = 0
        self.most = 0
        self._lock = threading.Lock()

    def __call__(self) -> Job:
        with self._lock:
            self.running += 1
            self.most = max(self.most, self.running)
        self.go.wait()
        with self._lock:
            self.running -= 1
        return JOB


async def ended(*submissions: PendingSubmission) -> None:
    await asyncio.gather(*(one.task for one in submissions if one.task is not None))


def refusing(error: Exception) -> Callable[[], Job]:
    def work() -> Job:
        raise error

    return work


def test_a_submission_becomes_a_job_or_says_why_not() -> None:
    async def scenario() -> None:
        all_of_them = Submissions()
        well = all_of_them.start("", "studio", "", lambda: JOB)
        bad = all_of_them.start("", "b", "", refusing(InputError("b", "is damaged")))
        assert (all_of_them.get(well.id), all_of_them.get("another")) == (well, None)
        await ended(well, bad)
        assert (well.job, well.error) == (JOB, None)
        assert (bad.job, str(bad.error)) == (None, "b: is damaged")

    asyncio.run(scenario())


def test_a_few_are_looked_at_at_once_and_one_of_each_key() -> None:
    async def scenario() -> None:
        all_of_them, looks = Submissions(at_once=2), Looks()
        mine = [all_of_them.start("me", "a", "", looks) for _ in range(5)]
        await asyncio.sleep(0.05)
        assert looks.running == 1
        others = [all_of_them.start(f"key {number}", "a", "", looks) for number in range(3)]
        await asyncio.sleep(0.05)
        assert [one.to_json()["state"] for one in (*mine, *others)] == (
            ["looking"] + ["waiting"] * 4 + ["looking"] + ["waiting"] * 2
        )
        looks.go.set()
        await ended(*mine, *others)
        assert looks.most <= 2

    asyncio.run(scenario())


def test_one_key_may_have_some_waiting_and_all_together_some_more(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_OF_ONE", 3)
    monkeypatch.setattr(module, "MOST_WAITING", 5)

    async def scenario() -> None:
        all_of_them, looks = Submissions(), Looks()
        for _ in range(3):
            all_of_them.start("me", "a", "", looks)
        with pytest.raises(ProblemError) as raised:
            all_of_them.start("me", "a", "", looks)
        assert (raised.value.status, raised.value.code) == (429, "submissions-waiting")
        assert raised.value.headers == {"Retry-After": "10"}
        for other in ("b", "c"):
            all_of_them.start(other, "a", "", looks)
        with pytest.raises(ProblemError) as raised:
            all_of_them.start("d", "a", "", looks)
        assert (raised.value.status, raised.value.code) == (503, "server-busy")
        looks.go.set()
        await ended(*(one for one in all_of_them._all.values()))
        all_of_them.start("me", "a", "", looks)  # there is room again

    asyncio.run(scenario())


def test_the_same_wish_is_looked_at_once() -> None:
    async def scenario() -> None:
        all_of_them, looks = Submissions(), Looks()
        first = all_of_them.start("me", "a", "k-1 digest", looks)
        assert all_of_them.start("me", "a", "k-1 digest", looks) is first
        assert all_of_them.start("you", "a", "k-1 digest", looks) is not first
        assert all_of_them.start("me", "a", "", looks) is not all_of_them.start("me", "a", "", looks)
        looks.go.set()
        await ended(first)
        assert all_of_them.start("me", "a", "k-1 digest", looks) is not first  # the table of jobs knows it now

    asyncio.run(scenario())


def test_what_waits_for_its_turn_is_not_waited_for() -> None:
    async def scenario() -> None:
        all_of_them, looks = Submissions(at_once=1), Looks()
        first, second = (all_of_them.start(name, "a", "", looks) for name in "ab")
        await asyncio.wait_for(all_of_them.wait(second, 3600), 60)
        waiting = asyncio.create_task(all_of_them.wait(first, 3600))
        await asyncio.sleep(0.02)
        assert not waiting.done()
        looks.go.set()
        await waiting
        assert first.job == JOB

    asyncio.run(scenario())


def test_the_end_of_a_submission_is_kept_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario() -> None:
        all_of_them = Submissions()
        first = all_of_them.start("me", "a", "", lambda: JOB)
        await ended(first)
        second = all_of_them.start("me", "a", "", lambda: JOB)
        assert all_of_them.get(first.id) is first
        await ended(second)
        monkeypatch.setattr(module, "KEPT_SECONDS", 0.0)
        all_of_them.start("me", "a", "", lambda: JOB)
        assert (all_of_them.get(first.id), all_of_them.get(second.id)) == (None, None)

    asyncio.run(scenario())


def test_a_server_that_stops_gives_up_what_waits() -> None:
    async def scenario() -> None:
        all_of_them, looks = Submissions(at_once=1), Looks()
        running, waiting = (all_of_them.start(name, "a", "", looks) for name in "ab")
        await asyncio.sleep(0.02)
        looks.go.set()  # the end of its reader
        await all_of_them.close()
        assert running.job == JOB
        assert isinstance(waiting.error, ProblemError)
        with pytest.raises(ProblemError, match="the server is stopping"):
            all_of_them.start("a", "a", "", looks)

    asyncio.run(scenario())
