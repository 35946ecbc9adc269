from __future__ import annotations

import pytest

from jobs.records.keys import Scope
from server.access.scopes import needed_scope, scene_of

CHUNK = "/v1/chunks/" + 64 * "0"


@pytest.mark.parametrize(
    ("method", "path", "scope"),
    [
        ("GET", "/v1/health", None),
        ("GET", "/", None),
        ("GET", "/view/studio", None),
        ("GET", "/assets/x.js", None),
        ("POST", "/v1/session", None),
        ("GET", "/v1/scenes", Scope.VIEW),
        ("HEAD", "/v1/scenes/studio", Scope.VIEW),
        ("GET", "/v1/scenes/studio/manifest", Scope.VIEW),
        ("GET", "/v1/scenes/studio/index.hgs", Scope.VIEW),
        ("GET", "/v1/scenes/studio/chunks/ab", Scope.VIEW),
        ("GET", CHUNK, Scope.VIEW),
        ("WEBSOCKET", "/v1/scenes/studio/stream", Scope.VIEW),
        ("PATCH", "/v1/scenes/studio", Scope.PUBLISH),
        ("DELETE", "/v1/scenes/studio", Scope.PUBLISH),
        ("POST", "/v1/links", Scope.PUBLISH),
        ("POST", "/v1/jobs", Scope.SUBMIT),
        ("DELETE", "/v1/jobs/job-1", Scope.SUBMIT),
        ("GET", "/v1/workers", Scope.SUBMIT),
        ("GET", "/v1/jobs/job-1/log", Scope.SUBMIT),
        ("GET", "/v1/captures", Scope.SUBMIT),
        ("PATCH", "/v1/uploads/x/files/0", Scope.SUBMIT),
        ("POST", "/v1/health", Scope.ADMIN),
        ("POST", "/", Scope.ADMIN),
        ("GET", "/v1", Scope.ADMIN),
        ("GET", "/v1/new-thing", Scope.ADMIN),
        ("GET", "/v1/scenes/studio/new-thing", Scope.ADMIN),
        ("POST", "/v1/scenes/studio/edits", Scope.SUBMIT),
        ("GET", "/v1/scenes/studio/edits", Scope.ADMIN),
        ("GET", "/metrics", Scope.ADMIN),
        ("GET", "/openapi.json", Scope.ADMIN),
        ("WEBSOCKET", "/v1/other", Scope.ADMIN),
    ],
)
def test_every_request_needs_a_scope_and_an_unknown_one_the_highest(
    method: str, path: str, scope: Scope | None
) -> None:
    assert needed_scope(method, path) is scope


@pytest.mark.parametrize("path", ["/v1/scenes", CHUNK, "/v1/jobs/studio", "/v1/scenes/a/b/c", "/v1/scenes/../x"])
def test_a_path_about_no_single_scene(path: str) -> None:
    assert scene_of(path) is None


@pytest.mark.parametrize("rest", ["", "/manifest", "/index.hgs", "/chunks/ab", "/thumbnail", "/stream"])
def test_a_path_about_a_scene(rest: str) -> None:
    assert scene_of(f"/v1/scenes/studio{rest}") == "studio"
