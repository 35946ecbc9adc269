"""`/v1/uploads`: uploads of captures; their files are in `upload_files.py` (docs/upload.md)."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse
from pydantic import BaseModel, ConfigDict, Field, StrictInt, StrictStr
from starlette.concurrency import run_in_threadpool

from jobs.records.job import JobState, Place
from server.access.clients import client_of
from server.http.conditional import respond_json
from server.http.problems import ProblemError
from server.http.request_body import read_json
from server.service import Service, ServiceDep
from server.uploads.upload import Announcement, Upload

__all__ = ["router"]

router = APIRouter(prefix="/v1/uploads")

_MOST_JOBS = 1000  # jobs per query
_TUS_BELOW = (
    "uploads begin with JSON, and only their files are resources of tus: POST {name, files, bytes} here, then give the "
    "tus client the endpoint /v1/uploads/{id}/files, and with every file the metadata path and sha256"
)


class Beginning(BaseModel):
    """The body of `POST /v1/uploads`."""

    model_config = ConfigDict(extra="forbid", strict=True)

    name: StrictStr = Field(min_length=1, max_length=200)
    files: StrictInt = Field(ge=1, le=2**53)
    bytes: StrictInt = Field(ge=0, le=2**53)
    key: StrictStr = Field(default="", max_length=64)


@router.options("")
def options() -> Response:
    """Reject a tus client that looks for an endpoint here."""
    raise ProblemError(405, "tus-endpoint", _TUS_BELOW, headers={"Allow": "GET, HEAD, POST"})


@router.post("")
async def begin(request: Request, service: ServiceDep) -> Response:
    """Start an upload, or continue the unfinished one with the same announcement."""
    service.origins.require_same_site(request)
    if "Tus-Resumable" in request.headers:
        raise ProblemError(422, "tus-endpoint", _TUS_BELOW, field="Tus-Resumable")
    body = await read_json(request, Beginning)
    announced = Announcement(body.name, body.files, body.bytes, body.key)
    upload, new = await run_in_threadpool(service.uploads.begin, announced, client_of(request))
    headers = {"Location": f"uploads/{upload.id}"}
    return JSONResponse(service.uploads.describe(upload), 201 if new else 200, headers)


@router.api_route("", methods=["GET", "HEAD"])
def list_uploads(request: Request, service: ServiceDep) -> Response:
    """List the uploads, newest first, with the limits."""
    uploads, limits = service.uploads.all(), service.uploads.limits
    told = {name: getattr(limits, name) for name in limits.__dataclass_fields__}
    return respond_json(request, {"uploads": [service.uploads.describe(one) for one in uploads], "limits": told})


@router.api_route("/{upload_id}", methods=["GET", "HEAD"])
def get_upload(request: Request, upload_id: str, service: ServiceDep) -> Response:
    """Describe one upload."""
    return respond_json(request, service.uploads.describe(service.uploads.get(upload_id)))


@router.post("/{upload_id}/finish")
async def finish(request: Request, upload_id: str, service: ServiceDep) -> Response:
    """Turn a complete upload into a capture."""
    service.origins.require_same_site(request)
    upload = await run_in_threadpool(service.uploads.get, upload_id)
    await service.long_work.run(service.uploads.finish, upload)  # may read all uploaded data
    return JSONResponse(service.uploads.describe(upload))


@router.delete("/{upload_id}", status_code=204)
async def delete(request: Request, upload_id: str, service: ServiceDep) -> Response:
    """Delete an upload, or its capture, unless a job needs it."""
    service.origins.require_same_site(request)
    upload = await run_in_threadpool(service.uploads.get, upload_id)
    await run_in_threadpool(_require_unused, service, upload)
    await service.long_work.run(service.uploads.delete, upload)
    return Response(status_code=204)


def _require_unused(service: Service, upload: Upload) -> None:
    """Reject the deletion while a waiting or running job reads the capture."""
    if not upload.capture:
        return
    folder = service.uploads.captures / upload.capture
    for state in (JobState.RUNNING, JobState.WAITING, JobState.QUEUED):
        after: Place | None = None
        while jobs := service.jobs.list(_MOST_JOBS, state, after):
            for job in jobs:
                if Path(job.capture).is_relative_to(folder):
                    detail = f"job {job.id} needs {upload.capture[:80]!r}; wait until it ends, or cancel it"
                    raise ProblemError(409, "capture-in-use", detail)
            if len(jobs) < _MOST_JOBS:
                break
            after = Place.of(jobs[-1])
