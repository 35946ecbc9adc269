"""Allowed methods of an API path, over all its routes."""

from __future__ import annotations

from starlette.requests import Request
from starlette.routing import Match, Route

__all__ = ["allowed_methods"]


def allowed_methods(request: Request) -> list[str]:
    """Return the methods of a request's path, sorted; none if no route of `app.state.api` matches."""
    found: set[str] = set()
    for route in getattr(request.app.state, "api", ()):
        if isinstance(route, Route) and route.matches(request.scope)[0] != Match.NONE:
            found |= route.methods or set()
    return sorted(found)
