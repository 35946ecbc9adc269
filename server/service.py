"""What the routes share: the queue, the store, and what is kept of them in memory."""

from __future__ import annotations

import asyncio
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Protocol, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from jobs.artifacts import SCENE_ID, SceneEntry
from jobs.home import Home
from jobs.job import Job, JobState, Place
from jobs.job_filter import JobFilter
from jobs.job_request import JobRequest
from jobs.run_reading import RunReader, run_reader
from jobs.webhook_table import Announcement
from jobs.worker_register import Worker
from server.access import Access, Visitor
from server.capture_checks import CaptureChecks
from server.capture_folders import CaptureFolders
from server.capture_list import CaptureList
from server.capture_readers import CaptureReaders
from server.chunk_cache import ChunkCache
from server.job_events import JobFollowers
from server.live_scenes import LiveScenes
from server.metrics import Metrics
from server.open_streams import OpenStreams
from server.problems import ProblemError
from server.scene_catalogue import SceneCatalogue
from server.scene_watchers import SceneWatchers
from server.slow_work import SlowWork
from server.submissions import Submissions
from server.uploads.uploads import Uploads

__all__ = ["Artifacts", "Jobs", "Service", "ServiceDep"]


class Jobs(Protocol):
    """The part of `jobs.client.JobClient` that the API uses."""

    def submit(self, request: JobRequest) -> str: ...  # noqa: D102
    def get(self, job_id: str) -> Job | None: ...  # noqa: D102
    def many(self, job_ids: Collection[str]) -> dict[str, Job]: ...  # noqa: D102
    def list(  # noqa: D102
        self,
        limit: int = 100,
        state: JobState | None = None,
        after: Place | None = None,
        wanted: JobFilter | None = None,
    ) -> list[Job]: ...
    def announcement(self, job_id: str) -> Announcement | None: ...  # noqa: D102
    def workers(self) -> Sequence[Worker]: ...  # noqa: D102
    def delete(self, job_id: str) -> None: ...  # noqa: D102
    def ahead_of(self, job: Job) -> int: ...  # noqa: D102
    def counts(self) -> dict[str, int]: ...  # noqa: D102
    def cancel(self, job_id: str) -> Job: ...  # noqa: D102
    def retry(self, job_id: str) -> Job: ...  # noqa: D102
    def close(self) -> None: ...  # noqa: D102


class Artifacts(Protocol):
    """The part of `jobs.artifacts.ArtifactStore` that the API uses."""

    def list_scenes(self) -> Sequence[SceneEntry]: ...  # noqa: D102
    def scene_entry(self, scene_id: str) -> SceneEntry | None: ...  # noqa: D102
    def manifest(self, scene_id: str) -> bytes | None: ...  # noqa: D102
    def pages(self, scene_id: str) -> bytes | None: ...  # noqa: D102
    def thumbnail(self, scene_id: str) -> bytes | None: ...  # noqa: D102
    def title(self, scene_id: str) -> str | None: ...  # noqa: D102
    def rename_scene(self, scene_id: str, title: str) -> None: ...  # noqa: D102
    def remove_scene(self, scene_id: str) -> None: ...  # noqa: D102
    def chunk(self, chunk_id: str) -> bytes | None: ...  # noqa: D102


@dataclass
class Service:
    """One running server's state; `stopping` is set when it begins to shut down, so that endless answers end."""

    home: Home
    jobs: Jobs
    artifacts: Artifacts
    chunks: ChunkCache
    captures: CaptureFolders
    uploads: Uploads
    access: Access
    readers: CaptureReaders
    origins: frozenset[str] = frozenset()  # of pages of other hosts that may read scenes, e.g. https://example.org
    metrics: Metrics = field(default_factory=Metrics)
    streams: OpenStreams = field(default_factory=OpenStreams)
    stopping: asyncio.Event = field(default_factory=asyncio.Event)
    followers: JobFollowers = field(init=False)
    catalogue: SceneCatalogue = field(init=False)
    capture_list: CaptureList = field(init=False)
    capture_checks: CaptureChecks = field(default_factory=CaptureChecks)
    submissions: Submissions = field(default_factory=Submissions)
    long_work: SlowWork = field(default_factory=lambda: SlowWork("long", 4))  # on whole captures and runs
    file_work: SlowWork = field(default_factory=lambda: SlowWork("file", 8))  # with pieces of files that arrive
    watchers: SceneWatchers = field(default_factory=SceneWatchers)
    live: LiveScenes = field(init=False)
    runs: RunReader = field(init=False)

    def __post_init__(self) -> None:
        """Make what is kept in memory of the queue and the store."""
        self.runs = run_reader(self.home)
        self.followers = JobFollowers(self.jobs, self.stopping)
        self.catalogue = SceneCatalogue(self.artifacts, self.jobs)
        self.capture_list = CaptureList(self.captures, self.readers)
        self.live = LiveScenes(self.catalogue.scene, self.watchers.tell)

    def known_job(self, job_id: str) -> Job:
        """Return a job.

        Raises:
            ProblemError: 404, there is no such job.
        """
        # Whatever else a client asks for, not every database can look up.
        job = self.jobs.get(job_id) if SCENE_ID.fullmatch(job_id) else None
        if job is None:
            raise ProblemError(404, "job-not-found", f"job {job_id[:64]}: no such job")
        return job

    def key_of(self, connection: HTTPConnection) -> str:
        """Return the id of the key that a request came with; "" of all that need none, who count as one."""
        visitor: Visitor | None = connection.scope.get("state", {}).get("visitor")
        return visitor.key.id if visitor is not None and visitor.key is not None else ""

    def same_site(self, connection: HTTPConnection) -> bool:
        """Return whether the request comes from no page, or from a page of this server."""
        origin = connection.headers.get("Origin")
        return origin is None or origin.partition("://")[2] == connection.headers.get("Host")

    def require_same_site(self, connection: HTTPConnection) -> None:
        """Refuse what would change something on behalf of a page of another site.

        Raises:
            ProblemError: 403.
        """
        if not self.same_site(connection):
            detail = f"a page of {connection.headers['Origin']} may not change anything on this server"
            raise ProblemError(403, "origin-not-allowed", detail)

    def may_read(self, connection: HTTPConnection) -> bool:
        """Return whether the page that asks, if any, may read scenes: browsers do not guard WebSockets themselves."""
        return self.same_site(connection) or connection.headers["Origin"] in self.origins or "*" in self.origins


def _service(connection: HTTPConnection) -> Service:
    return cast(Service, connection.app.state.service)


ServiceDep = Annotated[Service, Depends(_service)]
"""A route's parameter of this type is the server's `Service`."""
