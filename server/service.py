"""Shared state of the routes: the queue, the store and their caches."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import Annotated, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from jobs.artifacts.artifact_store import SCENE_ID
from jobs.home.home import Home
from jobs.records.job import Job
from jobs.runs.run_reading import RunReader, run_reader
from server.access.origins import OriginPolicy
from server.access.visitors import Access, Visitor
from server.captures.camera_pictures import CameraPictures
from server.captures.capture_folders import CaptureFolders
from server.captures.capture_list import CaptureList
from server.captures.capture_readers import CaptureReaders
from server.captures.check_requests import CaptureChecks
from server.captures.pending_submissions import Submissions
from server.http.metrics import Metrics
from server.http.problems import ProblemError
from server.http.slow_work import SlowWork
from server.job_views.job_followers import JobFollowers
from server.parts import Artifacts, Jobs
from server.scenes.chunk_cache import ChunkCache
from server.scenes.live_scenes import LiveScenes
from server.scenes.scene_catalogue import SceneCatalogue
from server.scenes.scene_watchers import SceneWatchers
from server.stream.admission import OpenStreams
from server.uploads.uploads import Uploads

__all__ = ["Service", "ServiceDep"]


@dataclass
class Service:
    """State of one running server; `stopping` is set when shutdown begins, so that endless responses end."""

    home: Home
    jobs: Jobs
    artifacts: Artifacts
    chunks: ChunkCache
    captures: CaptureFolders
    uploads: Uploads
    access: Access
    readers: CaptureReaders
    origins: OriginPolicy = field(default_factory=OriginPolicy)
    metrics: Metrics = field(default_factory=Metrics)
    streams: OpenStreams = field(default_factory=OpenStreams)
    stopping: asyncio.Event = field(default_factory=asyncio.Event)
    followers: JobFollowers = field(init=False)
    catalogue: SceneCatalogue = field(init=False)
    capture_list: CaptureList = field(init=False)
    camera_pictures: CameraPictures = field(init=False)
    capture_checks: CaptureChecks = field(default_factory=CaptureChecks)
    submissions: Submissions = field(default_factory=Submissions)
    long_work: SlowWork = field(default_factory=lambda: SlowWork("long", 4))  # whole captures and runs
    file_work: SlowWork = field(default_factory=lambda: SlowWork("file", 8))  # pieces of arriving files
    watchers: SceneWatchers = field(default_factory=SceneWatchers)
    live: LiveScenes = field(init=False)
    runs: RunReader = field(init=False)

    def __post_init__(self) -> None:
        """Create the in-memory views of the queue and the store."""
        self.runs = run_reader(self.home)
        self.followers = JobFollowers(self.jobs, self.stopping)
        self.catalogue = SceneCatalogue(self.artifacts, self.jobs)
        self.capture_list = CaptureList(self.captures, self.readers)
        self.camera_pictures = CameraPictures(self.captures, self.readers)
        self.live = LiveScenes(self.catalogue.scene, self.watchers.tell)

    def known_job(self, job_id: str) -> Job:
        """Return a job.

        Raises:
            ProblemError: 404, there is no such job.
        """
        # Not every database can look up arbitrary text.
        job = self.jobs.get(job_id) if SCENE_ID.fullmatch(job_id) else None
        if job is None:
            raise ProblemError(404, "job-not-found", f"job {job_id[:64]}: no such job")
        return job

    def key_of(self, connection: HTTPConnection) -> str:
        """Return the id of a request's key, or "" for all requests that need none: they count as one client."""
        visitor: Visitor | None = connection.scope.get("state", {}).get("visitor")
        return visitor.key.id if visitor is not None and visitor.key is not None else ""


def _service(connection: HTTPConnection) -> Service:
    return cast(Service, connection.app.state.service)


ServiceDep = Annotated[Service, Depends(_service)]
"""A route's parameter of this type is the server's `Service`."""
