"""The jobs that `hgs jobs` shows, of the home on this machine or of a server, in the form of docs/rest.md."""

from __future__ import annotations

from collections.abc import Sequence
from types import TracebackType
from typing import Any, Protocol, Self
from urllib.parse import quote, urlencode

from hgs_core.base.errors import InputError
from jobs.home.home import Home
from jobs.queue.client import JobClient, JobConflictError
from jobs.records.job import Job, JobState
from jobs.runs.run_reading import run_reader
from server.cli.server_client import FIRST_PATIENCE, RefusedError, ServerClient
from server.http.problems import ProblemError
from server.job_views.job_description import describe_job, describe_worker
from server.job_views.job_log import log_tail
from server.job_views.job_query import JobQuery, cursor

__all__ = ["HomeDesk", "JobDesk", "Query", "ServerDesk"]

Query = Sequence[tuple[str, str]]
"""The parameters of `GET /v1/jobs`."""


class JobDesk(Protocol):
    """The jobs of one installation, as JSON. Methods raise an InputError for a refused request."""

    def page(self, query: Query) -> dict[str, Any]: ...  # noqa: D102
    def job(self, job_id: str) -> dict[str, Any]: ...  # noqa: D102
    def log(self, job_id: str, lines: int) -> dict[str, Any]: ...  # noqa: D102
    def act(self, job_id: str, action: str) -> dict[str, Any]: ...  # noqa: D102
    def delete(self, job_id: str, *, scene: bool) -> None: ...  # noqa: D102
    def workers(self) -> dict[str, Any]: ...  # noqa: D102


class HomeDesk:
    """The jobs of a home, without a server."""

    def __init__(self, home: Home) -> None:
        """Open the queue of `home`."""
        self._home = home
        self._client = JobClient(home)

    def page(self, query: Query) -> dict[str, Any]:
        """Return a page of the list of jobs."""
        try:
            read = JobQuery.read(query)
        except ProblemError as error:
            raise InputError(f"--{error.field}", error.detail) from error
        jobs = self._client.list(read.limit + 1, read.state, read.after, read.wanted)
        page = jobs[: read.limit]
        more = cursor(page[-1]) if len(jobs) > len(page) else None
        return {"jobs": [describe_job(job) for job in page], "next": more}

    def job(self, job_id: str) -> dict[str, Any]:
        """Return a job."""
        return describe_job(self._known(job_id))

    def log(self, job_id: str, lines: int) -> dict[str, Any]:
        """Return the end of a job's log."""
        self._known(job_id)
        return log_tail(run_reader(self._home).folder(job_id), lines)

    def act(self, job_id: str, action: str) -> dict[str, Any]:
        """Cancel or retry a job, and return it as it then is."""
        self._known(job_id)
        try:
            job = self._client.cancel(job_id) if action == "cancel" else self._client.retry(job_id)
        except JobConflictError as error:
            raise InputError(f"job {job_id}", str(error)) from error
        if action == "cancel" and job.state is not JobState.CANCELLED:
            raise InputError(f"job {job_id}", f"{job.state.value}; a finished job cannot be cancelled")
        return describe_job(job)

    def delete(self, job_id: str, *, scene: bool) -> None:
        """Forget a finished job and remove its files, and its scene if that is asked for."""
        from jobs.artifacts.artifact_store import open_store

        job = self._known(job_id)
        try:
            self._client.delete(job_id)
        except JobConflictError as error:
            raise InputError(f"job {job_id}", str(error)) from error
        if scene and job.scene_id:
            open_store(self._home).remove_scene(job.scene_id)

    def workers(self) -> dict[str, Any]:
        """Return the workers that live."""
        found = [describe_worker(one) for one in self._client.workers()]
        return {"workers": found, "slots": len(found), "busy": sum(one["job"] is not None for one in found)}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self._client.close()

    def _known(self, job_id: str) -> Job:
        job = self._client.get(job_id)
        if job is None:
            raise InputError(f"job {job_id}", "no such job", "hgs jobs ls lists them")
        return job


class ServerDesk:
    """The jobs of a server elsewhere."""

    def __init__(self, url: str, patience: float = FIRST_PATIENCE) -> None:
        """Connect to nothing yet; `patience` is that of `ServerClient`.

        Raises:
            InputError: the URL is none of a server.
        """
        self._client = ServerClient(url, patience)

    def page(self, query: Query) -> dict[str, Any]:
        """Return a page of the list of jobs."""
        return self._ask("GET", f"/v1/jobs?{urlencode(query)}")

    def job(self, job_id: str) -> dict[str, Any]:
        """Return a job."""
        return self._ask("GET", _path(job_id))

    def log(self, job_id: str, lines: int) -> dict[str, Any]:
        """Return the end of a job's log."""
        return self._ask("GET", f"{_path(job_id)}/log?lines={lines}")

    def act(self, job_id: str, action: str) -> dict[str, Any]:
        """Cancel or retry a job, and return it as it then is."""
        return self._ask("POST", f"{_path(job_id)}/{action}")

    def delete(self, job_id: str, *, scene: bool) -> None:
        """Forget a finished job and remove its files, and its scene if that is asked for."""
        published = self.job(job_id)["scene"] if scene else None
        self._ask("DELETE", _path(job_id))
        if published is not None:
            try:
                self._ask("DELETE", f"/v1/scenes/{published}")
            except RefusedError as error:
                if error.code != "scene-not-found":  # already taken back
                    raise

    def workers(self) -> dict[str, Any]:
        """Return the workers that live."""
        return self._ask("GET", "/v1/workers")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self._client.close()

    def _ask(self, method: str, path: str) -> dict[str, Any]:
        answer: dict[str, Any] | None = self._client.request(method, path).value
        return answer or {}


def _path(job_id: str) -> str:
    return f"/v1/jobs/{quote(job_id, safe='')}"
