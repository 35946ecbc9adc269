"""A home behind the real application, in this process: its real store, SQLite and queue; a worker's acts by hand."""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
from pathlib import Path
from typing import Any

import httpx
from fastapi import FastAPI

from jobs.artifacts.artifact_store import ArtifactStore, open_store
from jobs.home.database import create_engine, open_client, prepare_database
from jobs.home.home import Home
from jobs.home.passing_faults import Cause
from jobs.process.stage_outcome import Waits
from jobs.process.stage_runner import StageRunner
from jobs.queue.client import JobClient
from jobs.queue.job_workflow import TrainingWorkflow
from jobs.records.job_table import JobTable, metadata
from jobs.runs.readiness import Surroundings
from server.app import create_app
from server.captures.capture_folders import CaptureFolders
from server.uploads.upload_limits import UploadLimits
from tests.server.modules import ready_pipeline

__all__ = ["OPEN_UPLOADS", "ServedHome"]

OPEN_UPLOADS = 2  # unfinished uploads of one client

_AWAY = Waits("the store is away", Cause.STORE)
_URL = "http://localhost"


class _KilledError(Exception):
    """Ends the application without its shutdown."""


class ServedHome:
    """The application on a home in `folder`, and one worker of it without processes."""

    def __init__(self, folder: Path) -> None:
        self.home = dataclasses.replace(Home.at(folder), pipeline=ready_pipeline.__name__)
        self._start()

    def _start(self) -> None:
        self.client = JobClient(self.home)
        self._app = create_app(
            self.home,
            captures=CaptureFolders((self.home.folder / "captures",)),
            uploads=UploadLimits(client=OPEN_UPLOADS, free=0),
            job_client=self.client,
        )
        self._loop = asyncio.Runner()
        self._life = self._app.router.lifespan_context(self._app)
        self._loop.run(self._life.__aenter__())
        self._requests = httpx.AsyncClient(transport=httpx.ASGITransport(self._app), base_url=_URL, trust_env=False)
        self._engine = create_engine(self.home)
        self._queue = open_client(self.home, self._engine)
        self.table = JobTable(self._engine)
        surroundings = Surroundings(self.home, prepare_database(self.home, self._engine, metadata))
        self._worker = TrainingWorkflow(self.home, surroundings, self._engine, self._queue, StageRunner(self.home))

    def stop(self) -> None:
        """Shut the server down."""
        self._loop.run(self._life.__aexit__(None, None, None))
        self._end()

    def die(self) -> None:
        """End as a killed process: the locks are free, and nothing of a shutdown is done."""
        with contextlib.suppress(_KilledError):
            self._loop.run(self._life.__aexit__(_KilledError, _KilledError(), None))
        self._app.state.service.uploads.close()
        self.client.close()
        self._end()

    def start_again(self) -> None:
        """Start another server on the home."""
        self._start()

    def _end(self) -> None:
        self._loop.close()
        self._queue.destroy()
        self._engine.dispose()

    @property
    def store(self) -> ArtifactStore:
        """The store of the home, opened anew."""
        return open_store(self.home)

    def ask(self, method: str, path: str, **arguments: Any) -> httpx.Response:
        """Send one request without a socket."""
        return self._loop.run(self._requests.request(method, path, **arguments))

    def ask_and_hang_up(self, method: str, path: str, headers: dict[str, str], body: bytes) -> None:
        """Send a request, and cut the line behind these bytes of its body."""
        self._loop.run(_hang_up(self._app, method, path, headers, body))

    def workflows(self) -> dict[str, str]:
        """Return the states of the queue's workflows by their names."""
        return {one.workflow_id: one.status for one in self._queue.list_workflows(load_input=False, load_output=False)}

    def make_scene(self, job_id: str) -> None:
        """Do the stages of a job up to its publication; those that are complete are left alone."""
        run = self.home.run(job_id)
        if not (run / "scene" / "manifest.json").exists():
            ready_pipeline.encode(run, lambda report: None)
        self.store.put_scene(run / "scene", job_id)

    def finish(self, job_id: str, attempt: int) -> None:
        """Do the last act of an attempt, once it has published."""
        self._worker._finish(job_id, attempt)

    def put_off(self, job_id: str, attempt: int) -> None:
        """Put an attempt off, as after a fault that passes."""
        self._worker._put_off(job_id, attempt, _AWAY, 0, "publish")

    def put_back(self, job_id: str) -> None:
        """Queue a job again, as after the death of its worker."""
        job = self.table.get(job_id)
        assert job is not None
        self.table.put_back(job, "its worker died")


async def _hang_up(app: FastAPI, method: str, path: str, headers: dict[str, str], body: bytes) -> None:
    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": method,
        "headers": [
            (name.lower().encode(), value.encode()) for name, value in {"host": "localhost", **headers}.items()
        ],
        "scheme": "http",
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "server": ("localhost", 80),
        "client": ("127.0.0.1", 1234),
        "root_path": "",
    }
    parts = iter([{"type": "http.request", "body": body, "more_body": True}])

    async def receive() -> dict[str, Any]:
        return next(parts, {"type": "http.disconnect"})

    async def send(message: Any) -> None:
        pass

    await app(scope, receive, send)  # type: ignore[arg-type]
