"""A TCP proxy on the loopback that forgets one WebSocket, as routers do: it stays open, and nothing passes any more."""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

__all__ = ["SwallowingProxy", "swallowing_proxy"]


@dataclass
class SwallowingProxy:
    """A proxy of `target`; the first WebSocket that has brought `limit` bytes is swallowed."""

    target: tuple[str, int]
    limit: int
    port: int = 0
    websockets: int = 0
    swallowed: threading.Event = field(default_factory=threading.Event)
    open: list[socket.socket] = field(default_factory=list)


@contextmanager
def swallowing_proxy(target: tuple[str, int], limit: int) -> Iterator[SwallowingProxy]:
    """Run a proxy; its connections are closed at the end."""
    proxy = SwallowingProxy(target, limit)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        proxy.port = listener.getsockname()[1]
        acceptor = threading.Thread(target=_accept, args=(proxy, listener), daemon=True)
        acceptor.start()
        try:
            yield proxy
        finally:
            listener.shutdown(socket.SHUT_RDWR)
            acceptor.join(30)
            for connection in proxy.open:
                with contextlib.suppress(OSError):
                    connection.shutdown(socket.SHUT_RDWR)
                connection.close()


def _accept(proxy: SwallowingProxy, listener: socket.socket) -> None:
    while True:
        try:
            client, _ = listener.accept()
        except OSError:
            return
        server = socket.create_connection(proxy.target)
        proxy.open += [client, server]
        hole = threading.Event()
        for source, sink, down in ((client, server, False), (server, client, True)):
            threading.Thread(target=_carry, args=(proxy, source, sink, hole, down), daemon=True).start()


def _carry(
    proxy: SwallowingProxy, source: socket.socket, sink: socket.socket, hole: threading.Event, down: bool
) -> None:
    passed, upgraded = 0, False
    with contextlib.suppress(OSError):
        while data := source.recv(4096):
            if down and passed == 0 and data.startswith(b"HTTP/1.1 101"):
                upgraded = True
                proxy.websockets += 1
            if upgraded and passed + len(data) > proxy.limit and not proxy.swallowed.is_set():
                proxy.swallowed.set()
                hole.set()
            if not hole.is_set():
                sink.sendall(data)
                passed += len(data)
    if not hole.is_set():
        with contextlib.suppress(OSError):
            sink.shutdown(socket.SHUT_WR)
