"""A model of the service: the uploads, jobs and scenes that a client may expect after the answers that it received."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from jobs.records.job import JobState
from tests.chunks import static_chunk
from tests.jobs.modules.scene_folder import write_scene

__all__ = ["Attempt", "Model", "ModelJob", "ModelScene", "ModelUpload", "captures_in", "tus_headers"]

Files = Mapping[str, bytes]  # content by path


@dataclass
class ModelUpload:
    """An upload: its announcement, the bytes that were acknowledged, and its capture once it is finished."""

    name: str
    key: str
    files: Files
    received: dict[str, int] = field(default_factory=dict)  # bytes, of the announced files
    places: dict[str, str] = field(default_factory=dict)  # addresses of the announced files
    capture: str = ""

    @property
    def announcement(self) -> dict[str, str | int]:
        """The body that begins it."""
        return {
            "name": self.name,
            "files": len(self.files),
            "bytes": sum(map(len, self.files.values())),
            "key": self.key,
        }

    @property
    def complete(self) -> bool:
        """Whether every byte was acknowledged."""
        return self.received == {path: len(content) for path, content in self.files.items()}

    @property
    def seen(self) -> tuple[str, int, int, str | None]:
        """Its state, received bytes, verified files and capture, as lists of the server have them."""
        if self.capture:
            return "finished", int(self.announcement["bytes"]), len(self.files), self.capture
        whole = sum(self.received.get(path) == len(content) for path, content in self.files.items())
        return "receiving", sum(self.received.values()), whole, None


@dataclass
class ModelJob:
    """A job: the request, its state and its attempt."""

    capture: str
    title: str
    key: str
    state: JobState = JobState.QUEUED
    attempt: int = 1

    @property
    def shown_title(self) -> str:
        """The title that people see."""
        return self.title or Path(self.capture).name


@dataclass(frozen=True)
class ModelScene:
    """A published scene: the content of its capture and its possible titles."""

    files: Files
    titles: frozenset[str]


@dataclass
class Attempt:
    """A worker's hold on an attempt at a job."""

    job_id: str
    number: int
    published: bool = False


@dataclass
class Model:
    """The whole service; ids that were deleted stay known."""

    uploads: dict[str, ModelUpload] = field(default_factory=dict)
    jobs: dict[str, ModelJob] = field(default_factory=dict)
    scenes: dict[str, ModelScene] = field(default_factory=dict)
    attempts: list[Attempt] = field(default_factory=list)
    gone: set[str] = field(default_factory=set)  # ids of deleted uploads and jobs
    paths: set[str] = field(default_factory=set)  # all captures that ever were
    made: dict[str, Files] = field(default_factory=dict)  # captures as encoded in the run folders, by job

    def unfinished(self) -> list[ModelUpload]:
        """Return the uploads that still receive bytes."""
        return [upload for upload in self.uploads.values() if not upload.capture]

    def content(self, capture: str) -> Files | None:
        """Return the files of a capture, or None if it is gone."""
        return next((upload.files for upload in self.uploads.values() if upload.capture == capture), None)

    def needed(self, capture: str) -> bool:
        """Return whether an unfinished job reads a capture."""
        return any(job.capture == capture and not job.state.finished for job in self.jobs.values())

    def current(self, attempt: Attempt) -> ModelJob | None:
        """Return the job of an attempt that may still change it, or None."""
        job = self.jobs.get(attempt.job_id)
        return job if job is not None and job.attempt == attempt.number and not job.state.finished else None

    def publish(self, job_id: str, files: Files, manifest_title: str) -> None:
        """Note a published scene; one that is there stays as it is."""
        titles = frozenset({self.jobs[job_id].shown_title, manifest_title})
        self.scenes.setdefault(job_id, ModelScene(files, titles))

    def rename(self, scene_id: str, title: str) -> None:
        """Note the new title of a scene."""
        self.scenes[scene_id] = dataclasses.replace(self.scenes[scene_id], titles=frozenset({title}))


def captures_in(folder: Path) -> list[Files]:
    """Return two captures of different sizes, for the stand-in for training; their scenes share a chunk."""
    found: list[Files] = []
    for name, contents in (("Near", (b"shared", b"near")), ("Far", (b"shared", b"far away"))):
        write_scene(folder / name / "scene", tuple(map(static_chunk, contents)), name)
        files = sorted(path for path in (folder / name).rglob("*") if path.is_file())
        found.append({path.relative_to(folder / name).as_posix(): path.read_bytes() for path in files})
    return found


def tus_headers(path: str, content: bytes) -> dict[str, str]:
    """Return the headers that announce a file."""
    told = {"path": path, "sha256": hashlib.sha256(content).hexdigest()}
    pairs = (f"{name} {base64.b64encode(value.encode()).decode()}" for name, value in told.items())
    return {"Tus-Resumable": "1.0.0", "Upload-Length": str(len(content)), "Upload-Metadata": ",".join(pairs)}
