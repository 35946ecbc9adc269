"""The server with one scene, in this process: no store on disk, no queue and no jobs."""

from __future__ import annotations

import asyncio
import contextlib
import json
import socket
import tempfile
from collections.abc import AsyncIterator, Collection
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, cast

from fastapi import FastAPI

from hgs_core.codec.format.paging import PagedScene
from jobs.artifacts.artifact_store import SceneEntry
from jobs.artifacts.scene_description import SceneDescription
from jobs.home.home import Home
from server.app import create_app
from server.bench.bench_scene import BenchScene
from server.listener.http_server import HttpServer, bind
from server.parts import Artifacts, Jobs

__all__ = ["application", "serving"]


class _OneScene:
    """A store that holds one scene, `bench`."""

    def __init__(self, scene: BenchScene) -> None:
        self._scene = scene

    def scene_entry(self, scene_id: str) -> SceneEntry | None:
        return SceneEntry("bench", datetime.now(UTC), "1") if scene_id == "bench" else None

    def describe(self, entry: SceneEntry) -> SceneDescription:
        return SceneDescription.of(json.loads(self._scene.document), len(self._scene.document))

    def manifest(self, scene_id: str) -> bytes | None:
        return self._scene.document if scene_id == "bench" else None

    def pages(self, scene_id: str, manifest: bytes) -> PagedScene | None:
        return self._scene.pages if scene_id == "bench" else None

    def title(self, scene_id: str) -> str | None:
        return None

    def thumbnail(self, scene_id: str) -> bytes | None:
        return None

    def chunk(self, chunk_id: str) -> bytes | None:
        return self._scene.chunks.get(chunk_id)


class _NoJobs:
    """A queue that has never had a job."""

    def many(self, job_ids: Collection[str]) -> dict[str, Any]:
        return {}


def application(scene: BenchScene, home: Path) -> FastAPI:
    """Return the server's application with a scene, `bench`, and a queue that has never had a job."""
    store, nothing = cast(Artifacts, _OneScene(scene)), cast(Jobs, _NoJobs())
    app = create_app(Home(home, "", ""), job_client=nothing, artifacts=store)
    app.router.lifespan_context = _no_lifespan
    return app


@asynccontextmanager
async def serving(scene: BenchScene, listener: socket.socket | None = None) -> AsyncIterator[int]:
    """Serve a scene as `bench` in this process, with the pages; gives the port, by default a free one."""
    with tempfile.TemporaryDirectory() as home, contextlib.closing(listener or bind("127.0.0.1", 0)) as listener:
        ready = asyncio.Event()
        server = HttpServer(application(scene, Path(home)), on_ready=ready.set)
        running = asyncio.create_task(server.serve(sockets=[listener]))
        try:
            await ready.wait()
            yield listener.getsockname()[1]
        finally:
            server.should_exit = True
            await running


@asynccontextmanager
async def _no_lifespan(_: Any) -> AsyncIterator[None]:
    yield
