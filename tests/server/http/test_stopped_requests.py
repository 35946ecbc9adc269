from __future__ import annotations

import asyncio
from typing import Any

import pytest

from server.http.stopped_requests import StoppedRequests


def sent_when_cancelled(*, begun: bool = False, stopping: bool = True, kind: str = "http") -> list[Any]:
    """Return the messages of a request that is cancelled while its application waits."""
    sent: list[Any] = []

    async def app(scope: Any, receive: Any, send: Any) -> None:
        if begun:
            await send({"type": "http.response.start", "status": 200, "headers": []})
        await asyncio.Event().wait()

    async def receive() -> Any:
        raise AssertionError("nothing is read")

    async def send(message: Any) -> None:
        sent.append(message)

    async def scenario() -> None:
        event = asyncio.Event()
        if stopping:
            event.set()
        scope = {"type": kind, "method": "GET", "path": "/v1/scenes", "headers": []}
        request = asyncio.ensure_future(StoppedRequests(app, event)(scope, receive, send))
        await asyncio.sleep(0)
        request.cancel()
        await request

    asyncio.run(scenario())
    return sent


def test_a_request_without_a_response_is_answered_with_503() -> None:
    start, body = sent_when_cancelled()
    assert start["status"] == 503
    assert b"the server is stopping" in body["body"]


@pytest.mark.parametrize("case", [{"begun": True}, {"stopping": False}, {"kind": "websocket"}])
def test_any_other_is_cancelled(case: dict[str, Any]) -> None:
    with pytest.raises(asyncio.CancelledError):
        sent_when_cancelled(**case)
