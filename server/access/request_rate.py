"""A limit on the requests of each client, so that one cannot take the server's time from the others."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Receive, Scope, Send

from server.access.clients import client_of
from server.http.problems import ProblemError, problem_response
from server.http.token_bucket import TokenBucket

__all__ = ["RequestRate"]

BURST_SECONDS = 4.0  # a page and its parts come at once
MOST_CLIENTS = 10_000  # clients remembered; whoever has asked for nothing the longest is forgotten


class RequestRate:
    """ASGI middleware, inside of access control: 429 for requests beyond a client's rate.

    A stream counts once, when it opens; its messages have limits of their own.
    """

    def __init__(self, app: ASGIApp, rate: float, clock: Callable[[], float] = time.monotonic) -> None:
        """Allow each client `rate` requests per second, and four seconds' worth at once; `clock` returns seconds."""
        self._app, self._rate, self._clock = app, rate, clock
        self._of_client: dict[str, TokenBucket] = {}  # the latest last

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, or refuse it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        wait = self._wait(client_of(connection))
        if not wait:
            await self._app(scope, receive, send)
            return
        detail = f"more than {self._rate:g} requests per second (--requests-per-second); try again later"
        refused = ProblemError(429, "too-many-requests", detail, headers={"Retry-After": str(math.ceil(wait))})
        await problem_response(connection, refused)(scope, receive, send)

    def _wait(self, client: str) -> float:
        """Return 0 and count the request, or return the seconds to wait; a refused one costs nothing."""
        bucket = self._of_client.pop(client, None) or TokenBucket(self._rate, max(1.0, BURST_SECONDS * self._rate))
        self._of_client[client] = bucket
        if len(self._of_client) > MOST_CLIENTS:
            del self._of_client[next(iter(self._of_client))]
        wait = bucket.spend(1, self._clock())
        if wait:
            bucket.earn(1)
        return wait
