"""`/v1/jobs`: submit captures, look at jobs, follow them, cancel and retry them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse, StreamingResponse
from pydantic import BaseModel, ConfigDict, Field, StrictStr
from starlette.concurrency import run_in_threadpool

from hgs_core.base.errors import InputError
from hgs_core.capture.held_out import AUTO
from hgs_core.runs.config import RunConfig
from hgs_core.runs.config_names import by_stage
from hgs_core.runs.sound import NO_SOUND, OWN_SOUND, camera_of_sound
from jobs.client import JobConflictError, KeyReusedError
from jobs.job import Job, JobState
from jobs.job_filter import MAX_LABELS
from jobs.job_request import MAX_TITLE, JobRequest
from server.conditional import respond_json
from server.job_events import describe_job, job_events, revision
from server.job_query import JobQuery, cursor
from server.problems import ProblemError
from server.request_body import read_json
from server.service import Service, ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/jobs")


class Submission(BaseModel):
    """The body of `POST /v1/jobs`."""

    model_config = ConfigDict(extra="forbid", strict=True)

    capture: StrictStr = Field(min_length=1, max_length=4096)
    title: StrictStr = Field(default="", max_length=MAX_TITLE)
    preset: StrictStr = "standard"
    hold_out: list[StrictStr] = Field(default=list(AUTO), max_length=1000)
    config: dict[str, Any] = {}
    audio: StrictStr = Field(
        default=OWN_SOUND,
        min_length=1,
        max_length=4096,
        description="What is heard: auto for the first camera's sound that has any, camera: and the name of one, none, "
        "or a file with sound, by its path in the capture or a whole path in a folder that the server may read.",
    )
    labels: list[StrictStr] = Field(default=[], max_length=MAX_LABELS)
    priority: int = 0
    time_limit: float = 0.0
    webhook: StrictStr = ""


@router.post("")
async def submit(request: Request, service: ServiceDep) -> Response:
    """Queue a job."""
    service.require_same_site(request)
    submission = await read_json(request, Submission, bounded="config")
    key = request.headers.get("Idempotency-Key", "")
    job = await run_in_threadpool(_submit, service, submission, key)
    return JSONResponse(describe_job(job), 201, {"Location": f"jobs/{job.id}"})


@router.api_route("", methods=["GET", "HEAD"])
def list_jobs(request: Request, service: ServiceDep) -> Response:
    """List the jobs: those that run, those that wait, those that are finished, each newest first."""
    query = JobQuery.read(request.query_params.multi_items())
    jobs = service.jobs.list(query.limit + 1, query.state, query.after, query.wanted)
    page = jobs[: query.limit]
    more = cursor(page[-1]) if len(jobs) > len(page) else None
    return respond_json(request, {"jobs": [describe_job(job) for job in page], "next": more})


@router.api_route("/{job_id}", methods=["GET", "HEAD"])
def get_job(job_id: str, service: ServiceDep) -> dict[str, Any]:
    """Describe one job."""
    return describe_job(service.known_job(job_id))


@router.get("/{job_id}/events")
async def events(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Follow one job until it is finished."""
    job = await run_in_threadpool(service.known_job, job_id)
    if job.state.finished and request.headers.get("Last-Event-ID") == revision(job):
        return Response(status_code=204)
    stream = job_events(service.followers, job)
    return StreamingResponse(stream, media_type="text/event-stream", headers={"Cache-Control": "no-store"})


@router.post("/{job_id}/cancel", status_code=202)
def cancel(request: Request, job_id: str, service: ServiceDep) -> dict[str, Any]:
    """Cancel a job."""
    service.require_same_site(request)
    service.known_job(job_id)
    job = service.jobs.cancel(job_id)
    if job.state is not JobState.CANCELLED:
        raise ProblemError(409, "job-finished", f"job {job_id}: {job.state.value}; a finished job cannot be cancelled")
    return describe_job(job)


@router.post("/{job_id}/retry", status_code=202)
def retry(request: Request, job_id: str, service: ServiceDep) -> dict[str, Any]:
    """Queue a failed or cancelled job again; it goes on from its last checkpoint."""
    service.require_same_site(request)
    service.known_job(job_id)
    try:
        return describe_job(service.jobs.retry(job_id))
    except JobConflictError as error:
        raise ProblemError(409, "job-not-retriable", str(error)) from error


@router.delete("/{job_id}", status_code=204)
def delete(request: Request, job_id: str, service: ServiceDep) -> Response:
    """Forget a finished job and remove its run folder; its scene stays published."""
    service.require_same_site(request)
    service.known_job(job_id)
    try:
        service.jobs.delete(job_id)
    except JobConflictError as error:
        raise ProblemError(409, "job-not-finished", str(error)) from error
    return Response(status_code=204)


def _submit(service: Service, submission: Submission, key: str) -> Job:
    try:
        config = _config(submission)
    except InputError as error:
        raise ProblemError(422, "config-invalid", str(error), field=_field(error)) from error
    try:
        capture: Path = service.captures.locate(submission.capture)
        asked = JobRequest(
            capture, config, submission.title, audio=_sound(service, submission.audio, capture),
            labels=tuple(submission.labels), priority=submission.priority, time_limit=submission.time_limit,
            webhook=submission.webhook, key=key,
        )  # fmt: skip
        job_id = service.jobs.submit(asked)
    except KeyReusedError as error:
        raise ProblemError(422, "idempotency-key-reused", str(error), field="Idempotency-Key") from error
    except InputError as error:
        if error.where in ("title", "labels", "priority", "time_limit", "webhook", "key"):
            field = "Idempotency-Key" if error.where == "key" else error.where
            raise ProblemError(422, "body-invalid", str(error), field=field) from error
        if error.where == "audio" or error.where.startswith("--audio"):
            raise ProblemError(422, "body-invalid", str(error).removeprefix("--"), field="audio") from error
        if error.where.startswith("config"):  # the capture does not fit the config
            raise ProblemError(422, "config-invalid", str(error), field=_field(error)) from error
        raise ProblemError(422, "capture-invalid", str(error), field="capture") from error
    return service.known_job(job_id)


def _sound(service: Service, audio: str, capture: Path) -> str:
    """Return what is asked for with a file's absolute path."""
    if audio in (OWN_SOUND, NO_SOUND) or camera_of_sound(audio) is not None:
        return audio
    return str(service.captures.locate_file("audio", audio, capture))


def _config(submission: Submission) -> RunConfig:
    overrides = by_stage(submission.config)
    capture = overrides.get("capture")
    for name, part in (("preset", overrides), ("hold_out", capture if isinstance(capture, dict) else {})):
        if name in part:
            place = "config.preset" if name == "preset" else "config.capture.hold_out"
            raise ProblemError(422, "config-invalid", f"{place}: give {name} beside config", field=place)
    return RunConfig.for_preset(submission.preset, **overrides).changed({"capture.hold_out": submission.hold_out})


def _field(error: InputError) -> str:
    """Return where a client gave what the config refuses: held-out cameras stand beside the config."""
    return error.where if error.where != "config.capture.hold_out" else "hold_out"
