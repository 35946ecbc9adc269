"""`POST /v1/jobs` and `/v1/submissions`: check of a capture, and creation of its job."""

from __future__ import annotations

import functools
from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse
from pydantic import BaseModel, ConfigDict, Field, StrictStr
from starlette.concurrency import run_in_threadpool

from hgs_core.base.errors import InputError
from hgs_core.capture.held_out import AUTO
from hgs_core.runs.config_names import by_stage
from hgs_core.runs.given_files import GivenFiles
from hgs_core.runs.run_config import RunConfig
from hgs_core.runs.sound_choice import NO_SOUND, OWN_SOUND, camera_of_sound
from jobs.queue.job_request import MAX_TITLE, JobRequest
from jobs.records.job import Job
from jobs.records.job_filter import MAX_LABELS
from server.captures.pending_submissions import PendingSubmission
from server.http.problem_error import ProblemError
from server.http.request_body import read_json
from server.job_views.job_description import describe_job
from server.routes.idempotency import IDEMPOTENCY_KEY, idempotency_key, refusing_reused_keys
from server.service import Service, ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1")

_PATIENCE = 5.0  # seconds that a response waits for a running check
_CODES = {"capture": "capture-invalid", "config": "config-invalid", "preset": "config-invalid"}
_PLACES = {"config.capture.hold_out": "hold_out", "key": IDEMPOTENCY_KEY}  # places outside the config and the body


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
        description="Sound of the scene: auto for the first camera with sound, camera: and a camera's name, none, "
        "or a sound file, by its path in the capture or its absolute path in a folder that the server may read.",
    )
    labels: list[StrictStr] = Field(default=[], max_length=MAX_LABELS)
    priority: int = 0
    time_limit: float = 0.0
    webhook: StrictStr = ""


@router.post("/jobs")
async def submit(request: Request, service: ServiceDep) -> Response:
    """Queue a job, once its capture has been checked."""
    service.origins.require_same_site(request)
    service.submissions.require_room(service.key_of(request))
    submission = await read_json(request, Submission, bounded="config")
    key = idempotency_key(request)
    asked = await run_in_threadpool(_asked, service, submission, key)
    wish = f"{key} {asked.digest}" if key else ""
    work = functools.partial(_submit, service, asked)
    pending = service.submissions.start(service.key_of(request), submission.capture, wish, work)
    return await _answer(service, pending, 201)


@router.api_route("/submissions/{submission_id}", methods=["GET", "HEAD"])
async def get_submission(submission_id: str, service: ServiceDep) -> Response:
    """Return the result of `POST /v1/jobs`: the job, or the reason why there is none."""
    pending = service.submissions.get(submission_id)
    if pending is None:
        detail = f"submission {submission_id[:64]!r}: not found among recent ones; look for its job, or submit it again"
        raise ProblemError(404, "submission-not-found", detail)
    return await _answer(service, pending, 200)


async def _answer(service: Service, pending: PendingSubmission, made: int) -> Response:
    """Wait a little; respond with the job and the status `made`, with an error, or with the submission's URL."""
    await service.submissions.wait(pending, _PATIENCE)
    if pending.error is not None:
        raise pending.error
    if pending.job is not None:
        job = f"jobs/{pending.job.id}"
        place = {"Location": job} if made == 201 else {"Content-Location": f"../{job}"}
        return JSONResponse(describe_job(pending.job), made, place)
    here = f"submissions/{pending.id}" if made == 201 else pending.id
    headers = {"Location": here, "Retry-After": "1", "Cache-Control": "no-store"}
    return JSONResponse(pending.to_json(), 202, headers)


def _asked(service: Service, submission: Submission, key: str) -> JobRequest:
    """Return the job request, checked as far as possible without reading files."""
    try:
        config = _config(submission)
        capture = service.captures.locate(submission.capture)
        audio = submission.audio
        if audio not in (OWN_SOUND, NO_SOUND) and camera_of_sound(audio) is None:
            audio = str(service.captures.locate_file("audio", audio, capture))
        return JobRequest(
            capture,
            config,
            submission.title,
            GivenFiles(audio=audio),
            labels=tuple(submission.labels),
            priority=submission.priority,
            time_limit=submission.time_limit,
            webhook=submission.webhook,
            key=key,
        )
    except InputError as error:
        raise _refused(service, error) from error


def _submit(service: Service, asked: JobRequest) -> Job:
    """Check the capture, and create its job."""
    try:
        service.captures.require_inner_links(asked.capture)
        with refusing_reused_keys():
            return service.known_job(service.jobs.submit(asked))
    except InputError as error:
        raise _refused(service, error) from error


def _refused(service: Service, error: InputError) -> ProblemError:
    """Return the problem for an invalid request."""
    told = service.captures.shown(str(error)).removeprefix("--")  # the command line's spelling of a field
    field = error.field or "capture"  # a file is one of the capture
    code = _CODES.get(field.partition(".")[0], "body-invalid")
    return ProblemError(422, code, told, field=_PLACES.get(field, field))


def _config(submission: Submission) -> RunConfig:
    overrides = by_stage(submission.config)
    capture = overrides.get("capture")
    for name, part in (("preset", overrides), ("hold_out", capture if isinstance(capture, dict) else {})):
        if name in part:
            place = "config.preset" if name == "preset" else "config.capture.hold_out"
            raise ProblemError(422, "config-invalid", f"{place}: give {name} beside config", field=place)
    return RunConfig.for_preset(submission.preset, **overrides).changed({"capture.hold_out": submission.hold_out})
