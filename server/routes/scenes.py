"""`/v1/scenes`: what has been published."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response
from starlette.concurrency import run_in_threadpool

from server.conditional import entity_tag, respond, respond_compressed, respond_json
from server.problems import ProblemError
from server.scene_catalogue import unknown_scene
from server.service import ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/scenes")


@router.api_route("", methods=["GET", "HEAD"])
async def scenes(request: Request, service: ServiceDep) -> Response:
    """List the published scenes, newest first."""
    found = await service.catalogue.scenes()
    return await run_in_threadpool(respond_json, request, {"scenes": found})


@router.api_route("/{scene_id}", methods=["GET", "HEAD"])
def scene(scene_id: str, service: ServiceDep) -> dict[str, Any]:
    """Describe one scene."""
    return service.catalogue.describe(scene_id)


@router.api_route("/{scene_id}/manifest", methods=["GET", "HEAD"])
def manifest(request: Request, scene_id: str, service: ServiceDep) -> Response:
    """Serve the manifest's exact bytes, compressed for those who ask."""
    body = service.artifacts.manifest(scene_id)
    if body is None:
        raise unknown_scene(scene_id)
    return respond_compressed(request, body, "application/json")


@router.api_route("/{scene_id}/thumbnail", methods=["GET", "HEAD"])
def thumbnail(request: Request, scene_id: str, service: ServiceDep) -> Response:
    """Serve the picture that stands for the scene."""
    body = service.artifacts.thumbnail(scene_id)
    if body is None:
        raise ProblemError(404, "thumbnail-not-found", f"scene {scene_id}: no such scene, or it has no thumbnail")
    return respond(request, body, "image/jpeg", etag=entity_tag(body), cache_control="no-cache")
