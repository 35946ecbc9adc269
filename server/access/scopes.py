"""Required scope of each request: `admin` unless listed here, so a new route is closed by default."""

from __future__ import annotations

import re

from jobs.records.keys import Scope

__all__ = ["needed_scope", "scene_of"]

_READS = frozenset({"GET", "HEAD"})
_SCENE = r"[a-z0-9][a-z0-9_-]{0,63}"

# Methods, path, scope; the first match counts. None: no key is required.
_RULES: tuple[tuple[frozenset[str] | None, re.Pattern[str], Scope | None], ...] = (
    (_READS, re.compile(r"/v1/health|/healthz|/readyz"), None),
    (None, re.compile(r"/v1/session"), None),  # the sign-in route
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
    (frozenset({"POST"}), re.compile(rf"/v1/scenes/{_SCENE}/edits"), Scope.SUBMIT),
    (None, re.compile(r"/v1/(?:jobs|submissions|captures|uploads|workers)(?:/.*)?"), Scope.SUBMIT),
)

_SCENE_PATH = re.compile(rf"/v1/scenes/({_SCENE})(?:/(?:manifest|index\.hgs|thumbnail|stream|chunks/[^/]*))?")


def needed_scope(method: str, path: str) -> Scope | None:
    """Return the scope required by a request, or None if no key is required. `WEBSOCKET` counts as a method."""
    for methods, pattern, scope in _RULES:
        if (methods is None or method in methods) and pattern.fullmatch(path):
            return scope
    return Scope.ADMIN


def scene_of(path: str) -> str | None:
    """Return the scene named by a path that a link may open, or None for other paths."""
    found = _SCENE_PATH.fullmatch(path)
    return found and found[1]
