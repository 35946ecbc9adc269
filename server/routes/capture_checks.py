"""`/v1/captures/check`: checks of captures before they become jobs (docs/upload.md)."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse
from pydantic import BaseModel, ConfigDict, Field, StrictStr
from starlette.concurrency import run_in_threadpool

from server.captures.check_requests import CaptureCheckRun
from server.http.problems import ProblemError
from server.http.request_body import read_json
from server.routes.captures import locate_capture, locate_closed_capture
from server.service import Service, ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/captures/check")


class Start(BaseModel):
    """The body of `POST /v1/captures/check`."""

    model_config = ConfigDict(extra="forbid", strict=True)

    capture: StrictStr = Field(min_length=1, max_length=4096)


@router.post("", status_code=202)
async def start(request: Request, service: ServiceDep) -> Response:
    """Start the check of a capture."""
    service.origins.require_same_site(request)
    body = await read_json(request, Start)
    capture = await service.long_work.run(locate_closed_capture, service, body.capture)
    return JSONResponse(_told(service, service.capture_checks.start(capture)), 202)


@router.get("")
async def get_check(capture: str, service: ServiceDep) -> dict[str, Any]:
    """Describe the last check of a capture."""
    check = service.capture_checks.get(await run_in_threadpool(locate_capture, service, capture))
    if check is None:
        raise ProblemError(404, "check-not-found", f"capture {capture[:80]!r}: has not been checked yet")
    return _told(service, check)


def _told(service: Service, check: CaptureCheckRun) -> dict[str, Any]:
    """Return the check object, with paths in its error relative to the server's folders."""
    told = check.to_json()
    return told | {"error": told["error"] and service.captures.shown(told["error"])}
