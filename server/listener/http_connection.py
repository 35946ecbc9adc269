"""HTTP connections with time-outs, which WebSockets leave behind while they keep their place."""

from __future__ import annotations

import asyncio
from http import HTTPStatus
from typing import Any, cast

import h11
from uvicorn.config import Config
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.server import ServerState

from server.http.problems import PROBLEM_JSON, ProblemError, problem_document
from server.listener.connection_limits import OpenConnections
from server.listener.strict_http import StrictConnection
from server.listener.websocket_protocol import WebSocketProtocol

__all__ = ["BODY_BYTES", "LINGER_SECONDS", "HttpConnection", "WebSocketConnection"]

BODY_BYTES = 64 << 10  # least progress of a body within `body_seconds`
LINGER_SECONDS = 1.0  # reading on after a refusal


class HttpConnection(H11Protocol):
    """Uvicorn's HTTP/1.1 connection, with time-outs and a place among the open connections.

    The limits are those of the server's state, an `OpenConnections`. A WebSocket that starts here drops the time-outs
    and keeps the place.
    """

    def __init__(
        self,
        config: Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, app_state, _loop)
        self.conn: StrictConnection = StrictConnection()
        self.address = ""
        self._open = cast(OpenConnections, server_state)
        self._awaited: object | None = None  # IDLE: the headers, SEND_BODY: the body, None: neither
        self._request_timer: asyncio.TimerHandle | None = None
        self._received = 0  # bytes, in all
        self._received_before = 0  # value when the timer of a body was set
        self._drain_timer: asyncio.TimerHandle | None = None
        self._lingers = False

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for a request, or refuse the connection."""
        super().connection_made(transport)
        self.address = self.client[0] if self.client else ""
        if self._open.admit(self):
            self._look()
        else:
            self._refuse(ProblemError(503, "too-many-connections", "too many connections; try again later"))

    def data_received(self, data: bytes) -> None:
        """Receive bytes of a request, and discard those of a refused one."""
        if self._lingers:
            return
        self._received += len(data)
        super().data_received(data)
        if self.transport.get_protocol() is self:
            self._look()

    def on_response_complete(self) -> None:
        """Wait for the next request; uvicorn closes the connection if none begins within `idle_seconds`."""
        super().on_response_complete()
        if self.transport.is_closing():
            self._watch_drain()
        elif self.conn.their_state is h11.IDLE:
            self._await(None)
            self._open.waits(self)
        else:
            self._look()

    def timeout_keep_alive_handler(self) -> None:
        """Close the idle connection when its turn comes."""
        timer = self.timeout_keep_alive_task

        def end() -> None:
            if timer is self.timeout_keep_alive_task:  # otherwise a request has arrived meanwhile
                super(HttpConnection, self).timeout_keep_alive_handler()
                self._watch_drain()

        self._open.in_turn(end)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand the connection over to the WebSocket."""
        self._await(None)
        super().handle_websocket_upgrade(event)
        cast(WebSocketConnection, self.transport.get_protocol()).began_as = self

    def send_400_response(self, msg: str) -> None:
        """Reject a malformed request with the reason."""
        refusal = self.conn.refusal
        if refusal is None:
            self._refuse(ProblemError(400, "bad-request", msg))
        else:
            self._refuse(ProblemError(refusal.error_status_hint, "bad-request", str(refusal)))

    def pause_writing(self) -> None:
        """Wait for the client to read pending data."""
        super().pause_writing()
        self._watch_drain()

    def resume_writing(self) -> None:
        """Resume writing."""
        super().resume_writing()
        self._stop_watching_drain()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        self._await(None)
        self._stop_watching_drain()
        self.leave()
        super().connection_lost(exc)

    def leave(self) -> None:
        """Release the connection's place."""
        self._open.release(self)

    def drop(self) -> None:
        """Close the connection at once, without an answer."""
        self.transport.abort()

    def _look(self) -> None:
        """Update the timer to the next expected part of the request."""
        state = self.conn.their_state
        self._await(state if state in (h11.IDLE, h11.SEND_BODY) else None)

    def _await(self, part: object | None) -> None:
        """Start the timer of the expected part of the request, unless it is running."""
        if part is None:
            self._open.works(self)
        if part is self._awaited:
            return
        if self._request_timer is not None:
            self._request_timer.cancel()
        self._awaited, self._request_timer = part, None
        if part is not None:
            limits = self._open.limits
            seconds = limits.head_seconds if part is h11.IDLE else limits.body_seconds
            self._request_timer = self.loop.call_later(seconds, self._time_out)
            self._received_before = self._received
            self._open.waits(self)

    def _time_out(self) -> None:
        """Give up when the connection's turn comes, unless the expected part has arrived by then."""
        timer = self._request_timer
        self._open.in_turn(lambda: self._give_up() if timer is self._request_timer else None)

    def _give_up(self) -> None:
        """End the connection, unless a long body is still wanted and arrives fast enough."""
        came = self._received - self._received_before
        if self._awaited is h11.SEND_BODY and self.conn.our_state is h11.SEND_RESPONSE and came >= BODY_BYTES:
            self._awaited = None
            self._look()
            return
        if self._awaited is h11.IDLE and not self.conn.trailing_data[0]:
            self.drop()  # no request: browsers open connections in advance, too
        else:
            self._refuse(ProblemError(408, "request-timeout", "the request was not complete in time"))

    def _refuse(self, problem: ProblemError) -> None:
        """Send a problem, if no response has begun, and close."""
        if self.conn.our_state not in (h11.IDLE, h11.SEND_RESPONSE):
            self.drop()
            return
        path = ""
        if self.conn.our_state is h11.SEND_RESPONSE and self.cycle is not None:
            path = self.scope["path"]
            self.cycle.disconnected = True  # its response has nowhere to go
        document = problem_document(problem, path)
        headers = {"Content-Type": PROBLEM_JSON, "Content-Length": str(len(document)), "Connection": "close"}
        events = (
            h11.Response(
                status_code=problem.status,
                headers=list(headers.items()),
                reason=HTTPStatus(problem.status).phrase.encode(),
            ),
            h11.Data(data=document),
            h11.EndOfMessage(),
        )
        self.transport.write(b"".join(self.conn.send(event) or b"" for event in events))
        if self.transport.get_write_buffer_size():
            self.drop()
        elif self._received:
            self._linger()
        else:
            self.transport.close()

    def _linger(self) -> None:
        """Read on for a moment: closing on unread bytes resets the connection and loses the answer (RFC 9112, 9.6)."""
        self._lingers = True
        self.transport.write_eof()
        self.loop.call_later(LINGER_SECONDS, self.transport.close)

    def _watch_drain(self) -> None:
        """Check later whether the client has read any pending data; nothing is added until then."""
        self._stop_watching_drain()
        left = self.transport.get_write_buffer_size()
        if left:
            self._drain_timer = self.loop.call_later(self._open.limits.stall_seconds, self._check_drain, left)

    def _check_drain(self, before: int) -> None:
        if self.transport.get_write_buffer_size() < before:
            self._watch_drain()
        else:
            self.drop()

    def _stop_watching_drain(self) -> None:
        if self._drain_timer is not None:
            self._drain_timer.cancel()
            self._drain_timer = None


class WebSocketConnection(WebSocketProtocol):
    """A WebSocket that releases its connection's place when it ends."""

    began_as: HttpConnection | None = None

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        if self.began_as is not None:
            self.began_as.leave()
        super().connection_lost(exc)
