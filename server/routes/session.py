"""`/v1/session`: exchange of a key for a cookie that scripts cannot read."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, ConfigDict, Field, StrictStr

from server.access.visitors import COOKIE, SESSION_SECONDS, Visitor
from server.http.problems import ProblemError
from server.http.request_body import read_json
from server.http.site_root import site_root
from server.service import ServiceDep

__all__ = ["router"]

router = APIRouter(prefix="/v1/session")


class Given(BaseModel):
    """The body of `POST /v1/session`."""

    model_config = ConfigDict(extra="forbid", strict=True)

    key: StrictStr = Field(min_length=1, max_length=200)


@router.api_route("", methods=["GET", "HEAD"])
async def session(request: Request, response: Response, service: ServiceDep) -> dict[str, Any]:
    """Return whether a key is required, and the scopes of the browser's session."""
    response.headers["Cache-Control"] = "no-store"
    if await service.access.open_to(request):
        return {"needed": False, "name": None, "scopes": []}
    visitor: Visitor | None = await service.access.visitor(request)
    key = visitor.key if visitor else None
    return {"needed": True, "name": key and key.name, "scopes": sorted(key.scopes) if key else []}


@router.post("", status_code=204)
async def begin(request: Request, service: ServiceDep) -> Response:
    """Check a key and set the cookie."""
    service.origins.require_same_site(request)
    begun = await service.access.session((await read_json(request, Given)).key.strip())
    if begun is None:
        raise ProblemError(401, "key-needed", "this is not a key of this server, or it is no longer valid", field="key")
    response = Response(status_code=204, headers={"Cache-Control": "no-store"})
    response.set_cookie(
        COOKIE,
        begun[0],
        max_age=SESSION_SECONDS,
        path=f"{site_root(request)}/",
        httponly=True,
        samesite="strict",
        secure=request.url.scheme == "https",
    )
    return response


@router.delete("", status_code=204)
async def end(request: Request, service: ServiceDep) -> Response:
    """Delete the session cookie."""
    service.origins.require_same_site(request)
    response = Response(status_code=204)
    response.delete_cookie(COOKIE, path=f"{site_root(request)}/", httponly=True, samesite="strict")
    return response
