"""Admission limit and staggered draining of open streams."""

from __future__ import annotations

import asyncio
import random
import re
from collections.abc import Callable

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.http.problems import ProblemError, problem_response
from server.protocol.stream_endings import Closing

__all__ = ["OpenStreams", "StreamAdmission"]

LATE_SECONDS = 1.0  # delay of the event loop above which new streams are rejected
RETRY_SECONDS = (5, 15)  # range of Retry-After for rejected clients
_INDEX = re.compile(r"/v1/scenes/[^/]+/index\.hgs")


class OpenStreams:
    """Open streams of one server process."""

    def __init__(self, limit: int | None = None, lag: Callable[[], float] = lambda: 0.0) -> None:
        """Admit at most `limit` streams (None: no limit), and none while the server's `lag()` is long."""
        self._limit, self._lag = limit, lag
        self._leave: set[asyncio.Event] = set()
        self._ending = False

    def __len__(self) -> int:
        """Return the number of open streams."""
        return len(self._leave)

    @property
    def ending(self) -> bool:
        """Whether the server is draining and admits no more streams."""
        return self._ending

    @property
    def full(self) -> bool:
        """Whether another stream would harm the open ones."""
        return self._ending or (self._limit is not None and len(self) >= self._limit) or self._lag() > LATE_SECONDS

    def join(self) -> asyncio.Event:
        """Add a stream; the event is set when it must end."""
        leave = asyncio.Event()
        self._leave.add(leave)
        return leave

    def part(self, leave: asyncio.Event) -> None:
        """Remove a stream."""
        self._leave.discard(leave)

    async def drain(self, seconds: float) -> None:
        """Admit no more streams, and end all evenly over `seconds`: their clients reconnect to another server."""
        self._ending = True
        remaining = list(self._leave)
        random.shuffle(remaining)
        for leave in remaining:
            if seconds > 0:
                await asyncio.sleep(seconds / len(remaining))
            leave.set()


class StreamAdmission:
    """ASGI middleware that rejects WebSockets with 503 when the server is full, and ends drained ones.

    Requests for a scene's index are rejected too, unless conditional: with them playback over HTTP begins.
    """

    def __init__(self, app: ASGIApp, streams: OpenStreams, refused: Callable[[], None]) -> None:
        """Guard `app`; call `refused` for each rejected request."""
        self._app, self._streams, self._refused = app, streams, refused

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Respond, or pass the request on."""
        if scope["type"] != "websocket" and not _begins_watching(scope):
            await self._app(scope, receive, send)
            return
        if self._streams.full:
            self._refused()
            detail = "the server is at its limit of streams; try again later"
            headers = {"Retry-After": str(random.randint(*RETRY_SECONDS))}
            problem = ProblemError(503, "server-busy", detail, headers=headers)
            await problem_response(HTTPConnection(scope), problem)(scope, receive, send)
            return
        if scope["type"] != "websocket":
            await self._app(scope, receive, send)
            return
        accepted = False

        async def watched(message: Message) -> None:
            nonlocal accepted
            accepted = accepted or message["type"] == "websocket.accept"
            await send(message)

        leave = self._streams.join()
        stream = asyncio.ensure_future(self._app(scope, receive, watched))
        told = asyncio.ensure_future(leave.wait())
        try:
            await asyncio.wait({stream, told}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._streams.part(leave)
            ended = stream.done()
            for task in (stream, told):
                task.cancel()
            await asyncio.gather(stream, told, return_exceptions=True)
        if ended:
            stream.result()
        elif accepted:
            await send({"type": "websocket.close", "code": Closing.RESTARTING.code})


def _begins_watching(scope: Scope) -> bool:
    """Return whether a client without the scene's index requests it."""
    index = scope["type"] == "http" and _INDEX.fullmatch(scope["path"]) is not None
    return index and "If-None-Match" not in HTTPConnection(scope).headers
