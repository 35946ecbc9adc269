"""Running the application under uvicorn: binding, announcing, and stopping without waiting for endless answers."""

from __future__ import annotations

import socket
from collections.abc import Callable

import uvicorn
from fastapi import FastAPI

from hgs_core.errors import InputError
from server.protocol import MAX_MESSAGE_BYTES
from server.service import Service
from server.websocket_protocol import WebSocketProtocol

__all__ = ["HttpServer", "bind"]

SHUTDOWN_SECONDS = 5


def bind(host: str, port: int) -> socket.socket:
    """Return a socket bound to the address; port 0 lets the system choose.

    Raises:
        InputError: the address is unknown, taken or not allowed.
    """
    if not 0 <= port <= 65535:
        raise InputError("--port", f"{port} is not a port", "give 0 to 65535")
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        listener = socket.socket(family, socket.SOCK_STREAM)
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


class HttpServer(uvicorn.Server):
    """Uvicorn with the settings that docs/protocol.md asks for."""

    def __init__(self, app: FastAPI, *, on_ready: Callable[[], None] = lambda: None) -> None:
        """Serve `app`; `on_ready` is called once when connections are accepted."""
        super().__init__(
            uvicorn.Config(
                app,
                log_level="warning",
                access_log=False,
                server_header=False,
                ws=WebSocketProtocol,
                # One message above our own limit still gets an `error` before the close.
                ws_max_size=2 * MAX_MESSAGE_BYTES,
                ws_per_message_deflate=False,  # chunks are compressed already
                timeout_graceful_shutdown=SHUTDOWN_SECONDS,
            )
        )
        self._service: Service = app.state.service
        self._on_ready = on_ready

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Begin to accept connections."""
        await super().startup(sockets)
        if self.started:
            self._on_ready()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """End event streams, close WebSockets with 1012, let the rest finish."""
        self._service.stopping.set()
        await super().shutdown(sockets)
