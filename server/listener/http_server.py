"""Running the application under uvicorn: binding, readiness, and shutdown that does not wait for endless responses."""

from __future__ import annotations

import gc
import socket
from collections.abc import Callable

import uvicorn
from fastapi import FastAPI

from hgs_core.base.errors import InputError
from server.listener.connection_limits import ConnectionLimits, OpenConnections, open_file_limit
from server.listener.http_connection import HttpConnection, WebSocketConnection
from server.protocol.messages import MAX_MESSAGE_BYTES
from server.service import Service

__all__ = ["HttpServer", "bind", "spare_collector"]

SHUTDOWN_SECONDS = 5
COLLECT_AFTER = (2000, 20, 25)  # thresholds of gc.set_threshold: generations 0, 1, 2
QUEUE = 2048  # connections waiting to be accepted


def bind(host: str, port: int) -> socket.socket:
    """Return a socket bound to the address; port 0 lets the system choose.

    Raises:
        InputError: the address is unknown, taken or not allowed.
    """
    if not 0 <= port <= 65535:
        raise InputError("--port", f"{port} is not a port", "give 0 to 65535")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        # With the protocol given, asyncio sets TCP_NODELAY: without it every response after a connection's first waits
        # for the client's delayed acknowledgement, 40 ms.
        listener = socket.socket(family, kind, protocol)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind(address)
        except BaseException:
            listener.close()
            raise
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(f"{host}:{port}", f"cannot listen: {reason}", "choose another --host or --port") from error
    return listener


def spare_collector() -> None:
    """Make garbage collection pause the streams of a starting server less often and for less time.

    Objects made so far are frozen and never scanned again. Long-lived objects are scanned only
    after a million new ones: with a thousand streams a scan takes some tenths of a second.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(*COLLECT_AFTER)


class HttpServer(uvicorn.Server):
    """Uvicorn with the settings required by docs/rest.md."""

    def __init__(
        self,
        app: FastAPI,
        *,
        limits: ConnectionLimits | None = None,
        drain: float = 0.0,
        on_ready: Callable[[], None] = lambda: None,
    ) -> None:
        """Serve `app` to connections within `limits`; call `on_ready` once they are accepted.

        When the server stops, it ends its streams evenly over `drain` seconds.
        """
        limits = limits or ConnectionLimits.for_files(open_file_limit())
        super().__init__(
            uvicorn.Config(
                app,
                http=HttpConnection,
                backlog=limits.batch,
                timeout_keep_alive=limits.idle_seconds,
                log_config=None,
                access_log=False,
                server_header=False,
                ws=WebSocketConnection,
                # One message above our own limit still gets an `error` before the close.
                ws_max_size=2 * MAX_MESSAGE_BYTES,
                ws_per_message_deflate=False,  # chunks are compressed already
                timeout_graceful_shutdown=SHUTDOWN_SECONDS,
            )
        )
        self.server_state = OpenConnections(limits)
        self._service: Service = app.state.service
        self._drain = drain
        self._on_ready = on_ready

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start to accept connections."""
        await super().startup(sockets)
        # Uvicorn's backlog is the number of connections that asyncio accepts together; more may wait in the kernel.
        for listener in sockets or ():
            listener.listen(QUEUE)
        if self.started:
            self._on_ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Accept no more connections, close WebSockets with 1012, end event streams, let other requests finish."""
        for server in self.servers:
            server.close()
        await self._service.streams.drain(self._drain)
        self._service.stopping.set()
        await super().shutdown(sockets)
