"""Many followers and one reader of the queue: counted, with a queue that changes at every query."""

from __future__ import annotations

import asyncio
import json
import logging
import threading
from collections.abc import AsyncIterator, Callable, Collection, Sequence
from typing import Any

import pytest
from sqlalchemy.exc import OperationalError

from jobs.records.job import Job, JobState
from server.job_views import job_followers as module
from server.job_views.job_followers import JobFollowers, job_events

QUEUED = Job("job-0", "Studio", "/captures/studio", {}, created=1.0, updated=1.0)
RUNNING = Job("job-0", "Studio", "/captures/studio", {}, JobState.RUNNING, stage="train", created=1.0, updated=2.0)
SUCCEEDED = Job("job-0", "Studio", "/captures/studio", {}, JobState.SUCCEEDED, created=1.0, updated=3.0)

Answer = Job | None | Exception | Callable[[], Job | None]


class ScriptedJobs:
    """A queue that gives the next answer at every question, and the last one for ever."""

    def __init__(self, *answers: Answer) -> None:
        self.answers: list[Answer] = list(answers)
        self.questions: list[frozenset[str]] = []

    def many(self, job_ids: Collection[str]) -> dict[str, Job]:
        answer = self.answers[min(len(self.questions), len(self.answers) - 1)]
        self.questions.append(frozenset(job_ids))
        if isinstance(answer, Exception):
            raise answer
        job = answer() if callable(answer) else answer
        return {} if job is None else {job.id: job}


@pytest.fixture(autouse=True)
def _fast(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "POLL_SECONDS", 0.02)


def state(event: bytes) -> str:
    return str(json.loads(event.decode().split("data: ")[1])["state"])


async def states(events: AsyncIterator[bytes]) -> list[str]:
    return [state(event) async for event in events if event.startswith(b"event")]


def follow(jobs: Any, followers: int = 1) -> list[list[str]]:
    """Return the states that so many followers of one job are told, to the end."""

    async def scenario() -> list[list[str]]:
        watch = JobFollowers(jobs, asyncio.Event())
        everybody = [states(job_events(watch, QUEUED)) for _ in range(followers)]
        return await asyncio.wait_for(asyncio.gather(*everybody), 60)

    return asyncio.run(scenario())


@pytest.mark.parametrize("followers", [1, 300])
def test_any_number_of_followers_costs_one_query_a_poll(followers: int) -> None:
    jobs = ScriptedJobs(QUEUED, RUNNING, RUNNING, SUCCEEDED)
    assert follow(jobs, followers) == [["queued", "running", "succeeded"]] * followers
    assert jobs.questions == [{"job-0"}] * 4


def test_nobody_asks_when_nobody_follows() -> None:
    jobs = ScriptedJobs(RUNNING)

    async def scenario() -> None:
        watch = JobFollowers(jobs, asyncio.Event())
        for _ in range(2):  # whoever comes after all have left is served again
            events = job_events(watch, QUEUED)
            assert [state(await anext(events)), state(await anext(events))] == ["queued", "running"]
            await events.aclose()  # type: ignore[attr-defined]
            asking = watch._asking
            assert asking is not None
            await asyncio.wait_for(asking, 30)
            asked = len(jobs.questions)
            await asyncio.sleep(5 * module.POLL_SECONDS)
            assert len(jobs.questions) == asked

    asyncio.run(scenario())


def test_followers_outlast_a_database_that_is_away(caplog: pytest.LogCaptureFixture) -> None:
    away = OperationalError("SELECT", {}, Exception("connection refused"))
    with caplog.at_level(logging.WARNING):
        assert follow(ScriptedJobs(RUNNING, away, away, away, SUCCEEDED), 3) == [["queued", "running", "succeeded"]] * 3
    assert len([record for record in caplog.records if "does not respond" in record.message]) == 1


def test_a_job_that_is_gone_ends_its_events() -> None:
    assert follow(ScriptedJobs(None)) == [["queued"]]


def test_a_server_that_stops_ends_all_events() -> None:
    async def scenario() -> None:
        stopping = asyncio.Event()
        watch = JobFollowers(ScriptedJobs(QUEUED), stopping)
        everybody = [asyncio.create_task(states(job_events(watch, QUEUED))) for _ in range(5)]
        await asyncio.sleep(0.1)
        stopping.set()
        assert await asyncio.wait_for(asyncio.gather(*everybody), 30) == [["queued"]] * 5
        assert watch._asking is not None
        await asyncio.wait_for(watch._asking, 30)

    asyncio.run(scenario())


def test_an_answer_older_than_the_follower_takes_nothing_back() -> None:
    asked, answer = threading.Event(), threading.Event()

    def slowly() -> Job:
        asked.set()
        assert answer.wait(30)
        return QUEUED

    jobs = ScriptedJobs(slowly, SUCCEEDED)

    async def scenario() -> tuple[Sequence[str], Sequence[str]]:
        watch = JobFollowers(jobs, asyncio.Event())  # type: ignore[arg-type]
        early = asyncio.create_task(states(job_events(watch, QUEUED)))
        await asyncio.to_thread(asked.wait, 30)
        late = job_events(watch, RUNNING)  # it was read after the queue had been asked
        told = [state(await anext(late))]
        rest = asyncio.create_task(states(late))
        await asyncio.sleep(0)
        answer.set()
        return await early, told + await asyncio.wait_for(rest, 30)

    early, late = asyncio.run(scenario())
    assert (early, late) == (["queued", "succeeded"], ["running", "succeeded"])


def test_silence_is_broken_for_proxies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "KEEP_ALIVE_SECONDS", 0.01)

    async def scenario() -> None:
        events = job_events(JobFollowers(ScriptedJobs(QUEUED), asyncio.Event()), QUEUED)
        assert (await anext(events)).startswith(b"event: job\n")
        assert await anext(events) == b":\n\n"
        await events.aclose()  # type: ignore[attr-defined]

    asyncio.run(scenario())
