"""Which scope each request needs. What is not named needs `admin`, so that a new route is closed until it is named."""

from __future__ import annotations

import re

from jobs.records.keys import Scope

__all__ = ["needed_scope", "scene_of"]

_READS = frozenset({"GET", "HEAD"})
_SCENE = r"[a-z0-9][a-z0-9_-]{0,63}"

# Methods, path, scope; the first that fits counts. None: nobody is asked for a key.
_RULES: tuple[tuple[frozenset[str] | None, re.Pattern[str], Scope | None], ...] = (
    (_READS, re.compile(r"/v1/health|/healthz|/readyz"), None),
    (None, re.compile(r"/v1/session"), None),  # where a key is given
    (
        _READS,
        re.compile(r"/(?!v1(?:/|$)|metrics$|openapi\.json$).*", re.DOTALL),
        None,
    ),  # the viewer's files hold no data
    (
        _READS,
        re.compile(
            rf"/v1/scenes(?:/{_SCENE}(?:/manifest|/index\.hgs|/thumbnail|/stream|/chunks/[^/]*)?)?|/v1/chunks/[^/]*"
        ),
        Scope.VIEW,
    ),
    (frozenset({"WEBSOCKET"}), re.compile(rf"/v1/scenes/{_SCENE}/stream"), Scope.VIEW),
    (frozenset({"PATCH", "DELETE"}), re.compile(rf"/v1/scenes/{_SCENE}"), Scope.PUBLISH),
    (frozenset({"POST"}), re.compile(r"/v1/links"), Scope.PUBLISH),
    (None, re.compile(r"/v1/(?:jobs|submissions|captures|uploads|workers)(?:/.*)?"), Scope.SUBMIT),
)

_SCENE_PATH = re.compile(rf"/v1/scenes/({_SCENE})(?:/(?:manifest|index\.hgs|thumbnail|stream|chunks/[^/]*))?")


def needed_scope(method: str, path: str) -> Scope | None:
    """Return the scope that a key needs for a request; None where none is asked for. `WEBSOCKET` counts as a method."""
    for methods, pattern, scope in _RULES:
        if (methods is None or method in methods) and pattern.fullmatch(path):
            return scope
    return Scope.ADMIN


def scene_of(path: str) -> str | None:
    """Return the scene that a path that a link may open is about; None if it is about no single scene."""
    found = _SCENE_PATH.fullmatch(path)
    return found and found[1]
