"""A small scene and a store that holds it, for the tests of the server."""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import hashlib
import json
import math
from collections.abc import AsyncIterator, Callable, Collection, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from hgs_core.base.progress import Progress, ProgressCallback
from hgs_core.codec.format.layers import SLICE_PART, STATIC_PART, layers
from hgs_core.codec.format.manifest_reading import parse_manifest
from hgs_core.codec.format.paging import PagedScene
from hgs_core.codec.format.scene_folder import load_manifest
from jobs.artifacts.artifact_store import SceneEntry
from jobs.artifacts.scene_description import SceneDescription
from jobs.home.home import Home
from jobs.queue.client import JobConflictError
from jobs.queue.edit_request import EditRequest
from jobs.queue.job_request import JobRequest
from jobs.records.announcements import Announcement
from jobs.records.job import Job, JobState, Place
from jobs.records.job_filter import JobFilter
from jobs.records.worker_register import Worker
from server.app import create_app
from server.captures.capture_folders import CaptureFolders
from server.listener.http_server import HttpServer, bind
from server.scenes.scene_index import Chunk, SceneIndex, Slice
from server.stream import admission
from tests.studio_scene import chunk_bytes, chunks, manifest, scene_folder

__all__ = ["chunks", "manifest", "scene_folder"]

SliceSpec = tuple[float, float, Sequence[int]]  # start, end, sizes of the chunks


@pytest.fixture
def make_scene() -> Callable[[Sequence[int], Sequence[SliceSpec]], SceneIndex]:
    """Return a function that builds a scene of static chunks of the given sizes and of slices."""

    def make(
        static: Sequence[int], slices: Sequence[SliceSpec], sounds: Sequence[tuple[float, float, int]] = ()
    ) -> SceneIndex:
        def chunks(name: str, sizes: Sequence[int], part: int) -> tuple[Chunk, ...]:
            names = [hashlib.sha256(chunk_bytes(f"{name} {k}", size)).digest() for k, size in enumerate(sizes)]
            return tuple(map(Chunk, names, sizes, layers(sizes, part), sizes))  # one splat for each byte

        pieces = tuple(
            Slice(start, end, chunks(f"slice {i} chunk", sizes, SLICE_PART))
            for i, (start, end, sizes) in enumerate(slices)
        )
        return SceneIndex(
            scene_id="studio",
            manifest=b'{"a": "manifest"}',
            document=b'{"a": "manifest"}',
            start=min((s for s, _, _ in slices), default=0.0),
            end=max((e for _, e, _ in slices), default=0.0),
            static=chunks("static", static, STATIC_PART),
            slices=pieces,
            sounds=tuple(
                Slice(begin, until, chunks(f"sound {i}", [size], SLICE_PART))
                for i, (begin, until, size) in enumerate(sounds)
            ),
        )

    return make


class FakeJobs:
    """A queue in memory that behaves as `jobs.queue.client.JobClient` does."""

    def __init__(self) -> None:
        self.jobs: dict[str, Job] = {}
        self.requests: list[JobRequest] = []
        self.edits: list[EditRequest] = []
        self.refuse: Exception | None = None
        self.closed = False
        self.alive: tuple[Worker, ...] = ()
        self.announcements: dict[str, Announcement] = {}

    def submit(self, request: JobRequest) -> str:
        if self.refuse is not None:
            raise self.refuse
        self.requests.append(request)
        job_id = f"job-{len(self.jobs)}"
        title = request.title or request.capture.name
        self.jobs[job_id] = Job(
            job_id,
            title,
            str(request.capture),
            request.config.to_json(),
            created=1.0,
            updated=1.0,
            labels=request.labels,
            priority=request.priority,
            time_limit=request.time_limit,
            webhook=request.webhook,
            audio=request.given.audio,
        )
        return job_id

    def edit(self, request: EditRequest) -> str:
        if request.scene != "studio":
            raise KeyError(request.scene)
        self.edits.append(request)
        job_id = f"edit-{len(self.jobs)}"
        self.jobs[job_id] = Job(job_id, request.title or "Studio", f"/runs/{job_id}/source/studio", {})
        return job_id

    def get(self, job_id: str) -> Job | None:
        if self.refuse is not None:
            raise self.refuse
        return self.jobs.get(job_id)

    def many(self, job_ids: Collection[str]) -> dict[str, Job]:
        return {job_id: job for job_id in job_ids if (job := self.get(job_id)) is not None}

    def list(
        self,
        limit: int = 100,
        state: JobState | None = None,
        after: Place | None = None,
        wanted: JobFilter | None = None,
    ) -> list[Job]:
        labels = wanted.labels if wanted is not None else ()
        found = [job for job in reversed(self.jobs.values()) if state in (None, job.state)]
        return [job for job in found if set(labels) <= set(job.labels)][:limit]

    def announcement(self, job_id: str) -> Announcement | None:
        return self.announcements.get(job_id)

    def workers(self) -> Sequence[Worker]:
        return self.alive

    def delete(self, job_id: str) -> None:
        job = self.jobs[job_id]
        if not job.state.finished:
            raise JobConflictError(f"job {job_id} is {job.state.value}")
        del self.jobs[job_id]

    def counts(self) -> dict[str, int]:
        if self.refuse is not None:
            raise self.refuse
        return {state.value: sum(job.state is state for job in self.jobs.values()) for state in JobState}

    def ahead_of(self, job: Job) -> int:
        return sum(other.state is JobState.QUEUED and other.id < job.id for other in self.jobs.values())

    def cancel(self, job_id: str) -> Job:
        if not self.jobs[job_id].state.finished:
            self.change(job_id, state=JobState.CANCELLED)
        return self.jobs[job_id]

    def retry(self, job_id: str) -> Job:
        job = self.jobs[job_id]
        if job.state not in (JobState.FAILED, JobState.CANCELLED):
            raise JobConflictError(f"job {job_id} is {job.state.value}")
        self.change(job_id, state=JobState.QUEUED, attempt=job.attempt + 1)
        return self.jobs[job_id]

    def close(self) -> None:
        self.closed = True

    def change(self, job_id: str, **fields: Any) -> None:
        """Change a job as a worker would."""
        job = self.jobs[job_id]
        self.jobs[job_id] = dataclasses.replace(job, **fields, updated=job.updated + 1)


@dataclasses.dataclass
class FakeArtifacts:
    """A store in memory."""

    chunks: dict[str, bytes] = dataclasses.field(default_factory=dict)
    manifests: dict[str, bytes] = dataclasses.field(default_factory=dict)
    thumbnails: dict[str, bytes] = dataclasses.field(default_factory=dict)
    titles: dict[str, str] = dataclasses.field(default_factory=dict)
    reads: int = 0

    def list_scenes(self) -> list[SceneEntry]:
        return [
            SceneEntry(
                scene_id,
                datetime.fromtimestamp(1000, UTC),
                hashlib.sha256(manifest).hexdigest(),
                self.titles.get(scene_id, ""),
            )
            for scene_id, manifest in sorted(self.manifests.items())
        ]

    def scene_entry(self, scene_id: str) -> SceneEntry | None:
        return next((entry for entry in self.list_scenes() if entry.id == scene_id), None)

    def manifest(self, scene_id: str) -> bytes | None:
        return self.manifests.get(scene_id)

    def describe(self, entry: SceneEntry) -> SceneDescription | None:
        manifest = self.manifests.get(entry.id)
        return None if manifest is None else SceneDescription.of(parse_manifest(manifest)[0], len(manifest))

    def pages(self, scene_id: str, manifest: bytes) -> PagedScene | None:
        return None

    def thumbnail(self, scene_id: str) -> bytes | None:
        return self.thumbnails.get(scene_id)

    def title(self, scene_id: str) -> str | None:
        return self.titles.get(scene_id)

    def rename_scene(self, scene_id: str, title: str) -> None:
        self.titles[scene_id] = title

    def remove_scene(self, scene_id: str) -> None:
        for kept in (self.manifests, self.thumbnails, self.titles):
            kept.pop(scene_id, None)

    def chunk(self, chunk_id: str) -> bytes | None:
        self.reads += 1
        return self.chunks.get(chunk_id)

    def add_chunk(self, data: bytes) -> str:
        """Store a chunk under its SHA-256."""
        chunk_id = hashlib.sha256(data).hexdigest()
        self.chunks[chunk_id] = data
        return chunk_id


@dataclasses.dataclass
class Server:
    """An application on fakes, and the fakes."""

    app: FastAPI
    jobs: FakeJobs
    artifacts: FakeArtifacts
    captures: Path
    home: Home

    def request(self, method: str, path: str, **arguments: Any) -> httpx.Response:
        """Send one request without a socket."""

        async def send() -> httpx.Response:
            transport = httpx.ASGITransport(self.app, raise_app_exceptions=False)
            async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
                return await client.request(method, path, **arguments)

        return asyncio.run(send())

    def get(self, path: str, **headers: str) -> httpx.Response:
        """GET with headers; underscores stand for hyphens."""
        return self.request("GET", path, headers={name.replace("_", "-"): value for name, value in headers.items()})


@pytest.fixture
def player(tmp_path: Path) -> Path:
    """A built player: its script, which loads a module and a wasm file."""
    folder = tmp_path / "viewer" / "player"
    (folder / "assets").mkdir(parents=True)
    (folder / "hgs-player.js").write_text('import "./assets/zstd-1a2b.js";')
    (folder / "assets" / "zstd-1a2b.js").write_text("1;")
    (folder / "assets" / "zstd-1a2b.wasm").write_bytes(b"\0asm")
    return folder


@pytest.fixture
def other_scene(scene_folder: Path, tmp_path: Path) -> Path:
    """A run like `scene_folder` with a scene of another title, without the last slice."""
    run = tmp_path / "other"
    (run / "scene" / "chunks").mkdir(parents=True)
    document = json.loads((scene_folder / "scene" / "manifest.json").read_text()) | {"title": "<Other> & more"}
    gone = document["slices"].pop()["chunks"]
    document["totals"]["splats_dynamic"] -= sum(chunk["splats"] for chunk in gone)
    document["totals"]["bytes_dynamic"] -= sum(chunk["bytes"] for chunk in gone)
    document["thumbnail"] = False
    (run / "scene" / "manifest.json").write_text(json.dumps(document))
    for entry in load_manifest(run / "scene").chunks:
        (run / "scene" / "chunks" / entry.id).write_bytes((scene_folder / "scene" / "chunks" / entry.id).read_bytes())
    return run


class Killed(BaseException):
    """Stands for a kill: nothing catches it."""


def killed_after(files: int) -> ProgressCallback:
    """Return a progress callback that ends the process, as it were, when so many files are under way."""

    def progress(report: Progress) -> None:
        if report.done == files:
            raise Killed

    return progress


@contextlib.asynccontextmanager
async def running_server(app: FastAPI, **settings: Any) -> AsyncIterator[tuple[HttpServer, str]]:
    """Serve on a loopback port of the system's choice; yield the server and host:port."""
    listener = bind("127.0.0.1", 0)
    server = HttpServer(app, **settings)
    task = asyncio.create_task(server.serve([listener]))
    while not server.started:
        await asyncio.sleep(0.01)
    try:
        yield server, f"127.0.0.1:{listener.getsockname()[1]}"
    finally:
        server.should_exit = True
        await asyncio.wait_for(task, 30)
        listener.close()


@pytest.fixture(autouse=True)
def no_late_refusals(monkeypatch: pytest.MonkeyPatch) -> None:
    """Admit streams however late the event loop is: a busy machine delays it too."""
    monkeypatch.setattr(admission, "LATE_SECONDS", math.inf)


@pytest.fixture
def server(tmp_path: Path) -> Server:
    captures = tmp_path / "captures"
    (captures / "studio").mkdir(parents=True)
    jobs, artifacts = FakeJobs(), FakeArtifacts()
    home = Home.at(tmp_path / "home")
    app = create_app(
        home,
        captures=CaptureFolders((captures.resolve(),)),
        job_client=jobs,
        artifacts=artifacts,
        viewer=tmp_path / "viewer",
    )
    return Server(app, jobs, artifacts, captures, home)
