"""Request ids, request metrics and the access log, one line of JSON per request."""

from __future__ import annotations

import json
import logging
import re
import secrets
import sys
import time
from datetime import UTC, datetime
from typing import TextIO

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.http.metrics import Metrics

__all__ = ["REQUEST_ID", "RequestLog", "configure_access_log"]

log = logging.getLogger("hgs.access")

REQUEST_ID = "X-Request-Id"
_DELETIONS = logging.WARNING  # level
_GIVEN = re.compile(r"[A-Za-z0-9._-]{1,64}")


def configure_access_log(stream: TextIO = sys.stderr, *, deletions_only: bool = False) -> None:
    """Write the access log to a stream: every request, or deletions alone, as people ask for their authors later."""
    handler = logging.StreamHandler(stream)
    handler.setFormatter(logging.Formatter("%(message)s"))
    log.addHandler(handler)
    log.setLevel(_DELETIONS if deletions_only else logging.INFO)
    log.propagate = False


class RequestLog:
    """ASGI middleware. A proxy's `X-Request-Id` is kept; the query is not logged, since it may hold a link."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app, self._metrics = app, metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on, and record its outcome."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        given = Headers(scope=scope).get(REQUEST_ID, "")
        identity = given if _GIVEN.fullmatch(given) else secrets.token_hex(8)
        started, sent, status = time.monotonic(), 0, 0
        is_http = scope["type"] == "http"

        async def noted(message: Message) -> None:
            nonlocal sent, status
            kind = message["type"]
            if kind in ("http.response.start", "websocket.http.response.start"):
                status = message["status"]
                MutableHeaders(scope=message)[REQUEST_ID] = identity
            elif kind == "websocket.accept":
                status = 101
                self._metrics.streams.inc()
            elif kind == "websocket.close":
                closed.append(message.get("code", 1000))
            sent += len(message.get("body") or message.get("bytes") or b"")
            if kind == "websocket.send":
                before = time.monotonic()
                await send(message)
                self._metrics.stream_send_seconds.observe(time.monotonic() - before)
            else:
                await send(message)

        async def heard() -> Message:
            message = await receive()
            if message["type"] == "websocket.disconnect":
                closed.append(message.get("code", 1005))
            return message

        closed: list[int] = []
        try:
            await self._app(scope, heard, noted)
        finally:
            self._metrics.sent_bytes.labels("http" if is_http else "stream").inc(sent)
            seconds = time.monotonic() - started
            if is_http:
                route = getattr(scope.get("route"), "path", "other")
                self._metrics.requests.labels(scope["method"], route, str(status)).inc()
                self._metrics.request_seconds.labels(route).observe(seconds)
            elif status == 101:
                self._metrics.streams.dec()
                self._metrics.stream_closes.labels(str(closed[0] if closed else 1006)).inc()
            level = _DELETIONS if scope.get("method") == "DELETE" else logging.INFO
            if log.isEnabledFor(level):
                log.log(level, _line(scope, identity, status, sent, seconds, closed))


def _line(scope: Scope, identity: str, status: int, sent: int, seconds: float, closed: list[int]) -> str:
    visitor = scope.get("state", {}).get("visitor")
    fields = {
        "time": datetime.now(UTC).isoformat(timespec="milliseconds"),
        "id": identity,
        "client": (scope.get("client") or ("", 0))[0],
        "key": visitor.key.name if visitor is not None and visitor.key is not None else None,
        "method": scope.get("method", "WEBSOCKET"),
        "path": scope["path"],
        "status": status,
        "bytes": sent,
        "seconds": round(seconds, 6),
    }
    if closed:
        fields["close"] = closed[0]
    return json.dumps(fields, separators=(",", ":"))
