"""`/v1/scenes`: list, describe, rename, delete and read published scenes."""

from __future__ import annotations

import unicodedata
from typing import Any

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, ConfigDict, Field, StrictStr
from starlette.concurrency import run_in_threadpool

from jobs.queue.job_request import MAX_TITLE
from server.http.conditional import entity_tag, respond, respond_compressed, respond_json
from server.http.problems import ProblemError
from server.http.request_body import read_json
from server.routes.chunks import chunk as respond_chunk
from server.routes.chunks import immutable
from server.scenes.scene_catalogue import unknown_scene
from server.service import Service, ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/scenes")


class Changes(BaseModel):
    """The body of `PATCH /v1/scenes/{id}`."""

    model_config = ConfigDict(extra="forbid", strict=True)

    title: StrictStr = Field(min_length=1, max_length=MAX_TITLE)


@router.api_route("", methods=["GET", "HEAD"])
async def scenes(request: Request, service: ServiceDep) -> Response:
    """List the published scenes, newest first."""
    found = await service.catalogue.scenes()
    return await run_in_threadpool(respond_json, request, {"scenes": found})


@router.api_route("/{scene_id}", methods=["GET", "HEAD"])
def scene(scene_id: str, service: ServiceDep) -> dict[str, Any]:
    """Describe one scene."""
    return service.catalogue.describe(scene_id)


@router.patch("/{scene_id}")
async def rename(request: Request, scene_id: str, service: ServiceDep) -> dict[str, Any]:
    """Change a scene's title."""
    service.origins.require_same_site(request)
    title = _one_line((await read_json(request, Changes)).title)
    return await run_in_threadpool(_rename, service, scene_id, title)


@router.delete("/{scene_id}", status_code=204)
async def delete(request: Request, scene_id: str, service: ServiceDep) -> Response:
    """Unpublish a scene and end its streams; its chunks stay, since other scenes may share them."""
    service.origins.require_same_site(request)
    await run_in_threadpool(_delete, service, scene_id)
    service.watchers.tell(scene_id)
    return Response(status_code=204)


@router.api_route("/{scene_id}/manifest", methods=["GET", "HEAD"])
def manifest(request: Request, scene_id: str, service: ServiceDep) -> Response:
    """Serve the manifest's exact bytes, compressed if the client accepts it."""
    body = service.artifacts.manifest(scene_id)
    if body is None:
        raise unknown_scene(scene_id)
    return respond_compressed(request, body, "application/json")


@router.api_route("/{scene_id}/index.hgs", methods=["GET", "HEAD"])
def index(request: Request, scene_id: str, service: ServiceDep) -> Response:
    """Serve the index; its pages and chunks have addresses beside it, as in a folder."""
    body = service.catalogue.scene(scene_id).manifest
    return respond(
        request, body, "application/octet-stream", etag=entity_tag(body), cache_control="no-cache", ranges=True
    )


@router.api_route("/{scene_id}/chunks/{chunk_id}", methods=["GET", "HEAD"])
async def chunk(request: Request, scene_id: str, chunk_id: str, service: ServiceDep) -> Response:
    """Serve a page of the scene's manifest, or one of its chunks, whole or in part."""
    found = await run_in_threadpool(service.catalogue.scene, scene_id)
    if chunk_id not in found.chunk_ids:
        raise ProblemError(404, "chunk-not-found", f"chunk {chunk_id[:64]}: not part of scene {scene_id}")
    page = found.page_bytes.get(bytes.fromhex(chunk_id))
    return await respond_chunk(request, chunk_id, service) if page is None else immutable(request, chunk_id, page)


@router.api_route("/{scene_id}/thumbnail", methods=["GET", "HEAD"])
def thumbnail(request: Request, scene_id: str, service: ServiceDep) -> Response:
    """Serve the thumbnail of a scene."""
    body = service.artifacts.thumbnail(scene_id)
    if body is None:
        raise ProblemError(404, "thumbnail-not-found", f"scene {scene_id}: no such scene, or it has no thumbnail")
    return respond(request, body, "image/jpeg", etag=entity_tag(body), cache_control="no-cache")


def _rename(service: Service, scene_id: str, title: str) -> dict[str, Any]:
    if service.artifacts.scene_entry(scene_id) is None:
        raise unknown_scene(scene_id)
    service.artifacts.rename_scene(scene_id, title)
    return service.catalogue.describe(scene_id)


def _delete(service: Service, scene_id: str) -> None:
    if service.artifacts.scene_entry(scene_id) is None:
        raise unknown_scene(scene_id)
    service.artifacts.remove_scene(scene_id)


def _one_line(title: str) -> str:
    """Return a title without surrounding spaces.

    Raises:
        ProblemError: 422, it is empty or contains control characters or line breaks.
    """
    title = title.strip()
    if not title:
        raise ProblemError(422, "body-invalid", "title: is empty; give one line of text", field="title")
    if any(unicodedata.category(one) in ("Cc", "Zl", "Zp") for one in title):
        detail = f"title: {title[:80]!a} contains control characters; give one line of text"
        raise ProblemError(422, "body-invalid", detail, field="title")
    return title
