"""`/v1/chunks`: immutable bytes, named by their SHA-256."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from server.http.conditional import respond
from server.http.problems import ProblemError
from server.scenes.chunk_cache import DamagedChunkError
from server.service import ServiceDep

__all__ = ["immutable", "router"]

router = APIRouter()


@router.api_route("/v1/chunks/{chunk_id}", methods=["GET", "HEAD"])
async def chunk(request: Request, chunk_id: str, service: ServiceDep) -> Response:
    """Serve a chunk, whole or in part."""
    try:
        data = await service.chunks.get(chunk_id)
    except DamagedChunkError as error:
        raise ProblemError(500, "chunk-damaged", str(error)) from error
    if data is None:
        raise ProblemError(404, "chunk-not-found", f"chunk {chunk_id[:64]}: no such chunk")
    return immutable(request, chunk_id, data)


def immutable(request: Request, chunk_id: str, data: bytes) -> Response:
    """Respond with immutable bytes, whole or in part; their SHA-256 is the entity tag."""
    return respond(
        request,
        data,
        "application/octet-stream",
        etag=f'"{chunk_id}"',
        cache_control="public, max-age=31536000, immutable",
        ranges=True,
    )
