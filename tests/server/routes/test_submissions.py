"""Submissions with captures still being checked; test_jobs.py has those answered with a job."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from typing import Any

import httpx
import pytest

from hgs_core.base.errors import InputError
from jobs.queue.job_request import JobRequest
from jobs.records.keys import Scope
from server.access.visitors import Access, Asking
from server.app import create_app
from server.captures import pending_submissions as queue
from server.captures.capture_folders import CaptureFolders
from server.routes import submissions as module
from tests.server.access_keys import FakeKeys

BODY = {"capture": "studio"}


class Readers:
    """Readers of captures that answer nothing until they are let go."""

    def __init__(self, submit: Callable[[JobRequest], str]) -> None:
        self.go = threading.Event()
        self.looks = 0
        self._submit = submit

    def submit(self, request: JobRequest) -> str:
        self.looks += 1
        self.go.wait()
        return self._submit(request)


@pytest.fixture
def readers(server: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Readers]:
    monkeypatch.setattr(module, "_PATIENCE", 0.0)
    readers = Readers(server.jobs.submit)
    monkeypatch.setattr(server.jobs, "submit", readers.submit)
    yield readers
    readers.go.set()


@contextlib.asynccontextmanager
async def asking(server: Any) -> AsyncIterator[httpx.AsyncClient]:
    transport = httpx.ASGITransport(server.app, raise_app_exceptions=False)
    async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
        yield client


async def looked_at(client: httpx.AsyncClient, answer: httpx.Response) -> httpx.Response:
    """Ask until a submission has been looked at."""
    place = answer.url.join(answer.headers["location"])
    while answer.status_code == 202:
        answer = await client.get(place)
        await asyncio.sleep(0.01)
    return answer


def test_a_submission_is_answered_at_once_and_the_job_can_be_asked_for(server: Any, readers: Readers) -> None:
    async def scenario() -> None:
        async with asking(server) as client:
            answer = await client.post("/v1/jobs", json=BODY)
            assert (answer.status_code, answer.headers["retry-after"]) == (202, "1")
            told = answer.json()
            assert answer.headers["location"] == f"submissions/{told['id']}"
            assert (told["capture"], told["state"], set(told)) == (
                "studio",
                "looking",
                {"id", "capture", "state", "seconds"},
            )
            readers.go.set()
            made = await looked_at(client, answer)
            assert (made.status_code, made.headers["content-location"]) == (200, "../jobs/job-0")
            assert made.json() == (await client.get("/v1/jobs/job-0")).json()

    asyncio.run(scenario())


def test_a_capture_that_is_refused_after_a_while_is_refused_as_it_would_have_been_at_once(
    server: Any, readers: Readers
) -> None:
    async def scenario() -> None:
        async with asking(server) as client:
            answer = await client.post("/v1/jobs", json=BODY)
            folder = server.captures.resolve() / "studio"
            server.jobs.refuse = InputError(folder / "cam1.mp4", "is damaged", "copy it again")
            readers.go.set()
            problem = (await looked_at(client, answer)).json()
            assert (problem["status"], problem["code"], problem["field"]) == (422, "capture-invalid", "capture")
            assert problem["detail"] == "studio/cam1.mp4: is damaged; copy it again"

    asyncio.run(scenario())


def test_while_captures_are_looked_at_everything_else_answers(server: Any, readers: Readers) -> None:
    async def scenario() -> None:
        async with asking(server) as client:
            answers = await asyncio.gather(*(client.post("/v1/jobs", json=BODY) for _ in range(400)))
            assert {one.status_code for one in answers} == {202, 429}
            assert sum(one.status_code == 202 for one in answers) == queue.MOST_OF_ONE
            for one in answers:
                assert one.headers["retry-after"]
                assert one.status_code == 202 or one.json()["code"] == "submissions-waiting"
            for page in ("/healthz", "/readyz", "/v1/health", "/v1/scenes", "/v1/jobs", "/v1/captures"):
                assert (await client.get(page)).status_code == 200
            assert readers.looks == 1  # whoever needs no key counts as one
            readers.go.set()

    asyncio.run(scenario())


def test_each_key_has_a_turn_of_its_own(server: Any, readers: Readers) -> None:
    keys = FakeKeys()
    texts = [keys.add(name, Scope.SUBMIT) for name in ("anna", "ben")]
    folders = CaptureFolders((server.captures.resolve(),))
    app = create_app(
        server.home,
        captures=folders,
        job_client=server.jobs,
        artifacts=server.artifacts,
        access=Access(keys, Asking.ALWAYS),
    )

    async def scenario() -> None:
        transport = httpx.ASGITransport(app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:

            async def submit(text: str) -> httpx.Response:
                return await client.post("/v1/jobs", json=BODY, headers={"Authorization": f"Bearer {text}"})

            for _ in range(queue.MOST_OF_ONE):
                assert (await submit(texts[0])).status_code == 202
            assert (await submit(texts[0])).status_code == 429
            assert (await submit(texts[1])).json()["state"] == "looking"
            readers.go.set()

    asyncio.run(scenario())


def test_the_same_request_with_the_same_key_is_looked_at_once(server: Any, readers: Readers) -> None:
    async def scenario() -> None:
        async with asking(server) as client:
            headers = {"Idempotency-Key": "k-1"}
            answers = [await client.post("/v1/jobs", json=BODY, headers=headers) for _ in range(3)]
            assert len({one.json()["id"] for one in answers}) == 1
            other = await client.post("/v1/jobs", json=BODY | {"title": "Other"}, headers=headers)
            assert other.json()["id"] != answers[0].json()["id"]
            readers.go.set()
            await looked_at(client, answers[0])

    asyncio.run(scenario())


def test_what_can_be_refused_without_a_look_is_refused_at_once(server: Any, readers: Readers) -> None:
    for body, status in (({"capture": "missing"}, 422), ({"capture": "/etc"}, 403), ({"preset": "none"} | BODY, 422)):
        assert server.request("POST", "/v1/jobs", json=body).status_code == status
    assert readers.looks == 0


def test_submissions_that_nobody_knows_are_404(server: Any) -> None:
    answer = server.get("/v1/submissions/" + "a" * 99)
    assert (answer.status_code, answer.json()["code"]) == (404, "submission-not-found")
