"""Answers to the requests that a stopping server waits for no longer."""

from __future__ import annotations

import asyncio

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.http.problems import ProblemError, problem_response

__all__ = ["StoppedRequests"]


class StoppedRequests:
    """ASGI middleware. A request that is cancelled before its response began is answered with 503, as one that comes
    too late; the listener would answer with 500, a fault of the server.
    """

    def __init__(self, app: ASGIApp, stopping: asyncio.Event) -> None:
        """Guard `app`; requests are cancelled once `stopping` is set."""
        self._app, self._stopping = app, stopping

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on."""
        begun = False

        async def watched(message: Message) -> None:
            nonlocal begun
            begun = True
            await send(message)

        try:
            await self._app(scope, receive, watched)
        except asyncio.CancelledError:
            if scope["type"] != "http" or begun or not self._stopping.is_set():
                raise
            detail = "the server is stopping; try again later"
            problem = ProblemError(503, "server-busy", detail, headers={"Retry-After": "5"})
            await problem_response(HTTPConnection(scope), problem)(scope, receive, send)
