"""What the routes share: the queue, the store, and what is kept of them in memory."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, Protocol, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from hgs_core.errors import InputError
from jobs.artifacts import SceneEntry
from jobs.client import JobRequest
from jobs.store import Job
from server.capture_folders import CaptureFolders
from server.chunk_cache import ChunkCache
from server.problems import ProblemError
from server.scene_index import SceneIndex, read_scene

__all__ = ["Artifacts", "Jobs", "Service", "ServiceDep"]

log = logging.getLogger("hgs.server")


class Jobs(Protocol):
    """The part of `jobs.client.JobClient` that the API uses."""

    def submit(self, request: JobRequest) -> str: ...  # noqa: D102
    def get(self, job_id: str) -> Job | None: ...  # noqa: D102
    def list(self, limit: int = 100) -> list[Job]: ...  # noqa: D102
    def cancel(self, job_id: str) -> Job: ...  # noqa: D102
    def retry(self, job_id: str) -> Job: ...  # noqa: D102
    def close(self) -> None: ...  # noqa: D102


class Artifacts(Protocol):
    """The part of `jobs.artifacts.ArtifactStore` that the API uses."""

    def list_scenes(self) -> Sequence[SceneEntry]: ...  # noqa: D102
    def manifest(self, scene_id: str) -> bytes | None: ...  # noqa: D102
    def thumbnail(self, scene_id: str) -> bytes | None: ...  # noqa: D102
    def chunk(self, chunk_id: str) -> bytes | None: ...  # noqa: D102


@dataclass
class Service:
    """One running server's state; `stopping` is set when it begins to shut down, so that endless answers end."""

    jobs: Jobs
    artifacts: Artifacts
    chunks: ChunkCache
    captures: CaptureFolders
    origins: frozenset[str] = frozenset()  # of pages of other hosts that may read scenes, e.g. https://example.org
    stopping: asyncio.Event = field(default_factory=asyncio.Event)
    _scenes: dict[str, SceneIndex] = field(default_factory=dict)

    def scene(self, scene_id: str) -> SceneIndex:
        """Return a published scene; blocks for a read of the store.

        Raises:
            ProblemError: 404, no such scene; 500, its manifest is of another version or damaged.
        """
        manifest = self.artifacts.manifest(scene_id)
        if manifest is None:
            self._scenes.pop(scene_id, None)
            raise ProblemError(404, "scene-not-found", f"scene {scene_id}: no such scene")
        known = self._scenes.get(scene_id)
        if known is None or known.manifest != manifest:
            try:
                known = self._scenes[scene_id] = read_scene(scene_id, manifest)
            except InputError as error:
                raise ProblemError(500, "internal", str(error)) from error
        return known

    def scenes(self) -> list[dict[str, Any]]:
        """Return the published scenes as JSON, newest first; blocks for reads of the store."""
        described = []
        for entry in self.artifacts.list_scenes():
            try:
                described.append(self._describe(self.scene(entry.id), entry.published.timestamp()))
            except ProblemError as error:
                log.warning("scene %s is left out of the list: %s", entry.id, error)
        return described

    def describe(self, scene_id: str) -> dict[str, Any]:
        """Return one scene as JSON.

        Raises:
            ProblemError: 404, no such scene.
        """
        scene = self.scene(scene_id)
        published = next((e.published.timestamp() for e in self.artifacts.list_scenes() if e.id == scene_id), 0.0)
        return self._describe(scene, published)

    def _describe(self, scene: SceneIndex, published: float) -> dict[str, Any]:
        job = self.jobs.get(scene.scene_id)  # a scene that a job made has the job's id
        return {
            "id": scene.scene_id,
            "title": job.title if job is not None else scene.title or scene.scene_id,
            "created": published,
            "start": scene.start,
            "end": scene.end,
            "bytes_total": scene.bytes_total,
            "splats_static": scene.splats_static,
            "splats_dynamic": scene.splats_dynamic,
        }

    def same_site(self, connection: HTTPConnection) -> bool:
        """Return whether the request comes from no page, or from a page of this server."""
        origin = connection.headers.get("Origin")
        return origin is None or origin.partition("://")[2] == connection.headers.get("Host")

    def may_read(self, connection: HTTPConnection) -> bool:
        """Return whether the page that asks, if any, may read scenes: browsers do not guard WebSockets themselves."""
        return self.same_site(connection) or connection.headers["Origin"] in self.origins or "*" in self.origins


def _service(connection: HTTPConnection) -> Service:
    return cast(Service, connection.app.state.service)


ServiceDep = Annotated[Service, Depends(_service)]
"""A route's parameter of this type is the server's `Service`."""
