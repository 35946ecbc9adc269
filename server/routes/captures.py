"""`/v1/captures`: captures available for jobs, and pictures of their cameras."""

from __future__ import annotations

from pathlib import Path

from fastapi import APIRouter, Request, Response
from starlette.concurrency import run_in_threadpool

from hgs_core.base.errors import InputError
from server.http.conditional import respond_json
from server.http.encodable import encodable
from server.http.problem_error import ProblemError
from server.service import Service, ServiceDep

__all__ = ["locate_capture", "locate_closed_capture", "router"]

router = APIRouter(prefix="/v1/captures")


@router.api_route("", methods=["GET", "HEAD"])
async def captures(request: Request, service: ServiceDep) -> Response:
    """List the captures in the folders that jobs may read."""
    return respond_json(request, await service.capture_list.describe())


@router.api_route("/pictures", methods=["GET", "HEAD"])
async def pictures(request: Request, capture: str, service: ServiceDep) -> Response:
    """Show the first picture of each camera of a capture."""
    try:
        found = await service.camera_pictures.of(await run_in_threadpool(locate_capture, service, capture))
    except InputError as error:
        raise _refused(service, error) from error
    return respond_json(request, {"pictures": encodable(found)})


def locate_capture(service: Service, capture: str) -> Path:
    """Return the path of a capture that a client names.

    Raises:
        ProblemError: 403 or 422, it may not be read, or there is none.
    """
    try:
        return service.captures.locate(capture)
    except InputError as error:
        raise _refused(service, error) from error


def locate_closed_capture(service: Service, capture: str) -> Path:
    """Return the path of a capture that a client names, after a check that its links stay in the readable folders.

    Raises:
        ProblemError: 403 or 422, it may not be read, or there is none.
    """
    found = locate_capture(service, capture)
    try:
        service.captures.require_inner_links(found)
    except InputError as error:
        raise _refused(service, error) from error
    return found


def _refused(service: Service, error: InputError) -> ProblemError:
    return ProblemError(422, "capture-invalid", service.captures.shown(str(error)), field="capture")
