"""`POST /v1/links`: links that let people without a key watch one scene for a limited time."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request
from pydantic import BaseModel, ConfigDict, Field, StrictInt, StrictStr
from starlette.concurrency import run_in_threadpool

from server.access.link_lifetime import LONGEST_LINK_SECONDS
from server.access.visitors import Visitor
from server.http.request_body import read_json
from server.http.site_root import site_root
from server.scenes.scene_catalogue import unknown_scene
from server.service import ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/links")


class Wish(BaseModel):
    """The body of `POST /v1/links`."""

    model_config = ConfigDict(extra="forbid", strict=True)

    scene: StrictStr = Field(min_length=1, max_length=64)
    seconds: StrictInt = Field(ge=1, le=LONGEST_LINK_SECONDS)


@router.post("", status_code=201)
async def link(request: Request, service: ServiceDep) -> dict[str, Any]:
    """Create a link."""
    service.origins.require_same_site(request)
    wish = await read_json(request, Wish)
    if await run_in_threadpool(service.artifacts.scene_entry, wish.scene) is None:
        raise unknown_scene(wish.scene)
    visitor: Visitor | None = request.state.visitor
    token = await service.access.link(wish.scene, wish.seconds, visitor.key if visitor else None)
    text = await service.access.sign(token)
    page = f"{site_root(request)}/view/{wish.scene}?link={text}"
    return {"link": text, "expires": token.expires, "page": page}
