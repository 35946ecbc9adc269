"""`/v1/captures`: captures available for jobs."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from server.http.conditional import respond_json
from server.service import ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/captures")


@router.api_route("", methods=["GET", "HEAD"])
async def captures(request: Request, service: ServiceDep) -> Response:
    """List the captures in the folders that jobs may read."""
    return respond_json(request, await service.capture_list.describe())
