"""Which methods an address of the API takes, whatever route takes each of them."""

from __future__ import annotations

from starlette.requests import Request
from starlette.routing import Match, Route

__all__ = ["allowed_methods"]


def allowed_methods(request: Request) -> list[str]:
    """Return the methods that the path of a request takes, sorted; none if no route of `app.state.api` is there."""
    found: set[str] = set()
    for route in getattr(request.app.state, "api", ()):
        if isinstance(route, Route) and route.matches(request.scope)[0] != Match.NONE:
            found |= route.methods or set()
    return sorted(found)
