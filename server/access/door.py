"""Access control of every request and WebSocket, before any route is looked up."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable

from sqlalchemy.exc import OperationalError
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from server.access.scopes import needed_scope, scene_of
from server.access.visitors import LINK, Access, Visitor
from server.http.problems import ProblemError, problem_response
from server.protocol.messages import Error, encode
from server.protocol.stream_endings import Closing

__all__ = ["AccessControl"]

CHECK_SECONDS = 5.0
_LONG = re.compile(r"/v1/jobs/[^/]+/events")
_CHUNK = re.compile(r"/v1/chunks/([0-9a-f]{64})")


class AccessControl:
    """ASGI middleware: 401 without a key, 403 with a key of too narrow a scope."""

    def __init__(self, app: ASGIApp, access: Access, chunks_of: Callable[[str], frozenset[str]]) -> None:
        """Guard `app`; `chunks_of` returns the ids of a scene's chunks, or none if there is no such scene."""
        self._app, self._access, self._chunks_of = app, access, chunks_of

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Respond, or pass the request on."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        try:
            visitor = await self._let_in(connection)
        except ProblemError as problem:
            await problem_response(connection, problem)(scope, receive, send)
            return
        except OperationalError:
            detail = "the keys cannot be looked up; try again later"
            unknown = ProblemError(503, "queue-unavailable", detail, headers={"Retry-After": "5"})
            await problem_response(connection, unknown)(scope, receive, send)
            return
        scope.setdefault("state", {})["visitor"] = visitor
        if visitor is None:
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket" or _LONG.fullmatch(scope["path"]):
            await self._while_it_holds(scope, receive, send, visitor)
        else:
            await self._app(scope, receive, _private(send))

    async def _let_in(self, connection: HTTPConnection) -> Visitor | None:
        """Return the visitor, or None where no key is required.

        Raises:
            ProblemError: 401 or 403.
        """
        scope = connection.scope
        method = "WEBSOCKET" if scope["type"] == "websocket" else scope["method"]
        needed = needed_scope(method, scope["path"])
        if needed is None or await self._access.open_to(connection):
            return None
        visitor = await self._access.visitor(connection)
        if visitor is None:
            detail = "a key is needed, or this one is no longer valid; send it as Authorization: Bearer KEY"
            if LINK in connection.query_params:
                detail = "this link has expired, or was not made by this server"
            if (why := self._access.why_closed(connection)) is not None:
                detail = f"this server requires a key: {why}; make one there with: hgs keys add NAME --scope admin"
            headers = {"WWW-Authenticate": 'Bearer realm="hgs"', "Cache-Control": "no-store"}
            raise ProblemError(401, "key-needed", detail, headers=headers)
        if not visitor.allows(needed) or not await self._opens(visitor, scope["path"]):
            what = f"the scope {needed}" if visitor.key else "a key: the link opens its own scene alone"
            headers = {"Cache-Control": "no-store"}
            raise ProblemError(403, "not-allowed", f"{method} {scope['path'][:300]} needs {what}", headers=headers)
        if visitor.by_cookie and method not in ("GET", "HEAD") and not _same_site(connection):
            raise ProblemError(403, "origin-not-allowed", "a page of another site may not use this browser's session")
        return visitor

    async def _opens(self, visitor: Visitor, path: str) -> bool:
        """Return whether a visitor's link, if any, covers the requested path."""
        if visitor.link is None:
            return True
        if (chunk := _CHUNK.fullmatch(path)) is not None:
            return chunk[1] in await run_in_threadpool(self._chunks_of, visitor.link.scene)
        return scene_of(path) == visitor.link.scene

    async def _while_it_holds(self, scope: Scope, receive: Receive, send: Send, visitor: Visitor) -> None:
        """Pass on a long conversation, and end it as soon as its key or link is no longer valid."""
        accepted = False

        async def watched(message: Message) -> None:
            nonlocal accepted
            accepted = accepted or message["type"] == "websocket.accept"
            await send(message)

        passed = watched if scope["type"] == "websocket" else _private(watched)
        conversation = asyncio.ensure_future(self._app(scope, receive, passed))
        try:
            while not conversation.done():
                left = min(CHECK_SECONDS, max(0.0, self._access.seconds_left(visitor)))
                await asyncio.wait({conversation}, timeout=left)
                if not conversation.done() and not await self._still(HTTPConnection(scope)):
                    break
        finally:
            ended = conversation.done()
            conversation.cancel()
            await asyncio.gather(conversation, return_exceptions=True)
        if ended:
            conversation.result()
        elif scope["type"] == "http":
            await send({"type": "http.response.body", "body": b"", "more_body": False})
        elif accepted:
            text = "the link has expired" if visitor.link else "the key is no longer valid"
            await send({"type": "websocket.send", "bytes": encode(Error("access-ended", text))})
            await send({"type": "websocket.close", "code": Closing.ACCESS_ENDED.code})

    async def _still(self, connection: HTTPConnection) -> bool:
        try:
            return await self._access.visitor(connection) is not None
        except OperationalError:
            return False


def _private(send: Send) -> Send:
    """Return a `send` that keeps guarded responses out of shared caches."""

    async def send_privately(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            stored = headers.get("Cache-Control", "private")
            headers["Cache-Control"] = stored.replace("public", "private")
            headers.add_vary_header("Authorization")
            headers.add_vary_header("Cookie")
        await send(message)

    return send_privately


def _same_site(connection: HTTPConnection) -> bool:
    origin = connection.headers.get("Origin")
    return origin is None or origin.partition("://")[2] == connection.headers.get("Host")
