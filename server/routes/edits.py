"""`POST /v1/scenes/{id}/edits`: a job that makes a new scene of a published one."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse

from hgs_core.base.errors import InputError
from jobs.queue.edit_request import EditRequest
from server.http.problems import ProblemError
from server.http.request_body import read_bytes
from server.job_views.job_description import describe_job
from server.routes.idempotency import IDEMPOTENCY_KEY, idempotency_key, refusing_reused_keys
from server.scenes.scene_catalogue import unknown_scene
from server.service import Service, ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/scenes")

MAX_EDIT_BYTES = 16 << 20


@router.post("/{scene_id}/edits", status_code=201)
async def edit(request: Request, scene_id: str, service: ServiceDep, title: str = "") -> Response:
    """Queue an edit; the body is a list of splats or a crop, which the job's first stage reads."""
    service.origins.require_same_site(request)
    document = await read_bytes(request, MAX_EDIT_BYTES)
    try:
        asked = EditRequest(scene_id, document, title, idempotency_key(request))
    except InputError as error:
        field = IDEMPOTENCY_KEY if error.field == "key" else error.field
        raise ProblemError(422, "body-invalid", str(error), field=field) from error
    return await service.long_work.run(_queue, service, asked)  # copies the scene


def _queue(service: Service, asked: EditRequest) -> Response:
    try:
        with refusing_reused_keys():
            job = service.known_job(service.jobs.edit(asked))
    except KeyError as error:
        raise unknown_scene(asked.scene) from error
    return JSONResponse(describe_job(job), 201, {"Location": f"../../jobs/{job.id}"})
