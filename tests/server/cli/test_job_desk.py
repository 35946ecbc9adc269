"""The same questions to the home on this machine and to a server of it: the answers are the same."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from hgs_core.base.errors import InputError
from hgs_core.runs.run_config import RunConfig
from jobs.home.home import Home
from jobs.queue.client import JobClient
from jobs.queue.job_request import JobRequest
from server.app import create_app
from server.cli.job_desk import HomeDesk, JobDesk, ServerDesk
from server.cli.server_client import Answer, RefusedError, ServerClient
from tests.server.conftest import running_server


@contextlib.contextmanager
def serving(home: Home) -> Iterator[str]:
    """Serve a home from a thread; yield the address."""
    ready, done = threading.Event(), threading.Event()
    address: list[str] = []

    async def serve() -> None:
        async with running_server(create_app(home)) as (_, host):
            address.append(host)
            ready.set()
            await asyncio.to_thread(done.wait)

    thread = threading.Thread(target=asyncio.run, args=(serve(),))
    thread.start()
    assert ready.wait(60)
    try:
        yield f"http://{address[0]}"
    finally:
        done.set()
        thread.join()


@pytest.fixture
def job(home: Path, n3dv: Path) -> str:
    with JobClient(Home.at(home)) as client:
        return client.submit(JobRequest(n3dv, RunConfig(), labels=("night",)))


@pytest.fixture(params=["home", "server"])
def desk(request: pytest.FixtureRequest, home: Path, job: str) -> Iterator[JobDesk]:
    if request.param == "home":
        with HomeDesk(Home.at(home)) as desk:
            yield desk
    else:
        with serving(Home.at(home)) as address, ServerDesk(address) as desk:
            yield desk


def test_a_job_is_looked_after(desk: JobDesk, home: Path, job: str) -> None:
    assert [one["id"] for one in desk.page([("label", "night")])["jobs"]] == [job]
    assert desk.page([("label", "day")]) == {"jobs": [], "next": None}
    assert desk.job(job)["labels"] == ["night"]
    assert desk.log(job, 5) == {"lines": [], "complete": True}
    assert desk.workers() == {"workers": [], "slots": 0, "busy": 0}
    with pytest.raises(InputError, match="retried"):
        desk.act(job, "retry")
    assert desk.act(job, "cancel")["state"] == "cancelled"
    assert desk.act(job, "retry")["state"] == "queued"
    with pytest.raises(InputError, match="cancel it"):
        desk.delete(job, scene=False)
    desk.act(job, "cancel")
    desk.delete(job, scene=True)
    assert list((home / "runs").iterdir()) == []
    with pytest.raises(InputError, match="no such job"):
        desk.job(job)
    with pytest.raises(InputError, match="limit"):
        desk.page([("limit", "0")])


@pytest.mark.parametrize(("status", "code", "refused"), [(404, "scene-not-found", False), (403, "not-allowed", True)])
def test_a_scene_that_may_not_be_deleted_with_its_job_is_told_of(
    monkeypatch: pytest.MonkeyPatch, status: int, code: str, refused: bool
) -> None:
    def request(client: ServerClient, method: str, path: str) -> Answer:
        if path == "/v1/scenes/dance":
            raise RefusedError(client.url, Answer(status, {}, {"code": code, "detail": "needs the scope publish"}))
        return Answer(200, {}, {"scene": "dance"})

    monkeypatch.setattr(ServerClient, "request", request)
    expected = pytest.raises(InputError, match="needs the scope publish") if refused else contextlib.nullcontext()
    with ServerDesk("http://127.0.0.1:1") as desk, expected:
        desk.delete("dance-1", scene=True)
