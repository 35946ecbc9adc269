from __future__ import annotations

import asyncio
from typing import Any

import pytest
from starlette.datastructures import Headers

from server.http.security_headers import CONSOLE_POLICY, EMBEDDABLE_POLICY, SecurityHeaders


def answered(kind: str, headers: dict[str, str]) -> Headers:
    """Return the headers of an application's answer as they leave the middleware."""
    sent: list[Any] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        raw = [(name.lower().encode(), value.encode()) for name, value in headers.items()]
        await send({"type": kind, "status": 200, "headers": raw})
        await send({"type": "http.response.body", "body": b"x"})

    async def receive() -> Any:
        raise AssertionError("nothing is read")

    async def send(message: Any) -> None:
        sent.append(message)

    asyncio.run(SecurityHeaders(app)({"type": "http"}, receive, send))
    assert sent[1] == {"type": "http.response.body", "body": b"x"}
    return Headers(raw=sent[0]["headers"])


@pytest.mark.parametrize("kind", ["http.response.start", "websocket.http.response.start"])
def test_every_answer_tells_browsers_to_take_care(kind: str) -> None:
    headers = answered(kind, {"Content-Type": "text/plain"})
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "same-origin"
    assert headers["content-security-policy"] == "default-src 'none'; frame-ancestors 'none'"
    assert headers["content-type"] == "text/plain"


def test_a_policy_that_an_answer_has_is_kept() -> None:
    headers = answered("http.response.start", {"Content-Security-Policy": CONSOLE_POLICY})
    assert headers.getlist("content-security-policy") == [CONSOLE_POLICY]


def test_the_accepting_of_a_websocket_is_passed_on_as_it_is() -> None:
    assert answered("websocket.accept", {}).keys() == []


@pytest.mark.parametrize("policy", [CONSOLE_POLICY, EMBEDDABLE_POLICY])
def test_pages_load_and_run_what_comes_from_the_server_alone(policy: str) -> None:
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert rules["default-src"] == rules["base-uri"] == rules["form-action"] == "'none'"
    assert all({"'self'", "'none'", "data:", "'wasm-unsafe-eval'"} >= set(rule.split()) for rule in rules.values())
    assert "data:" not in rules["script-src"]


def test_any_site_may_frame_a_scene_and_none_the_console() -> None:
    assert "frame-ancestors 'none'" in CONSOLE_POLICY
    assert "frame-ancestors" not in EMBEDDABLE_POLICY
