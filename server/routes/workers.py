"""`GET /v1/workers`: live workers and their jobs."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from server.http.conditional import respond_json
from server.http.encodable import encodable
from server.job_views.job_description import describe_worker
from server.service import ServiceDep

__all__ = ["router"]

router = APIRouter()


@router.api_route("/v1/workers", methods=["GET", "HEAD"])
def workers(request: Request, service: ServiceDep) -> Response:
    """List the workers; each has one slot, for one job at a time."""
    described = [describe_worker(one) for one in service.jobs.workers()]
    busy = sum(one["job"] is not None for one in described)
    return respond_json(request, encodable({"workers": described, "slots": len(described), "busy": busy}))
