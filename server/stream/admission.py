"""The streams that are open: no more than the server can carry, and none cut off all at once when it stops."""

from __future__ import annotations

import asyncio
import random
import re
from collections.abc import Callable

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.http.problems import ProblemError, problem_response

__all__ = ["OpenStreams", "StreamAdmission"]

LATE_SECONDS = 1.0  # of the event loop, from which on nobody else is let in
RETRY_SECONDS = (5, 15)  # between which a refused client is told to come again
RESTARTING = 1012
_INDEX = re.compile(r"/v1/scenes/[^/]+/index\.hgs")


class OpenStreams:
    """The streams of one server process."""

    def __init__(self, limit: int | None = None, lag: Callable[[], float] = lambda: 0.0) -> None:
        """Let in at most `limit` streams, None: as many as come, and none while the server's `lag()` is long."""
        self._limit, self._lag = limit, lag
        self._leave: set[asyncio.Event] = set()
        self._ending = False

    def __len__(self) -> int:
        """Return how many streams are open."""
        return len(self._leave)

    @property
    def ending(self) -> bool:
        """Whether the server lets nobody in any more."""
        return self._ending

    @property
    def full(self) -> bool:
        """Whether another stream would harm those that are there."""
        return self._ending or (self._limit is not None and len(self) >= self._limit) or self._lag() > LATE_SECONDS

    def join(self) -> asyncio.Event:
        """Add a stream; the event is set when it is to end."""
        leave = asyncio.Event()
        self._leave.add(leave)
        return leave

    def part(self, leave: asyncio.Event) -> None:
        """Take a stream away."""
        self._leave.discard(leave)

    async def drain(self, seconds: float) -> None:
        """Let nobody in any more, and end all streams, evenly over so many seconds: their clients connect elsewhere."""
        self._ending = True
        remaining = list(self._leave)
        random.shuffle(remaining)
        for leave in remaining:
            if seconds > 0:
                await asyncio.sleep(seconds / len(remaining))
            leave.set()


class StreamAdmission:
    """ASGI middleware: refuses WebSockets with 503 where there are enough, and ends those that are told to leave.

    A scene's index is refused with them to whoever asks for it anew: that is how watching over HTTP begins.
    """

    def __init__(self, app: ASGIApp, streams: OpenStreams, refused: Callable[[], None]) -> None:
        """Guard `app`; `refused` is called for each that is turned away."""
        self._app, self._streams, self._refused = app, streams, refused

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer, or pass on."""
        if scope["type"] != "websocket" and not _begins_watching(scope):
            await self._app(scope, receive, send)
            return
        if self._streams.full:
            self._refused()
            detail = "the server has as many streams as it can carry; try again later"
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
            await send({"type": "websocket.close", "code": RESTARTING})


def _begins_watching(scope: Scope) -> bool:
    """Return whether a scene's index is asked for by a client that does not have it."""
    index = scope["type"] == "http" and _INDEX.fullmatch(scope["path"]) is not None
    return index and "If-None-Match" not in HTTPConnection(scope).headers
