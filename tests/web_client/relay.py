"""A relay between a browser and a server, which counts bytes and can hold an answer back or cut it off."""

from __future__ import annotations

import re
import socket
import socketserver
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager

_REQUEST = re.compile(rb"^(?:GET|POST) (\S+) HTTP/1\.1\r\n", re.MULTILINE)


class Relay(socketserver.ThreadingTCPServer):
    """Listens on a loopback port of the system's choice."""

    daemon_threads = True
    request_queue_size = 64

    def __init__(self, server: tuple[str, int]) -> None:
        super().__init__(("127.0.0.1", 0), _Connection)
        self.server = server
        self.requests: list[str] = []  # paths in the order of the requests
        self.received: Counter[str] = Counter()  # bytes of the answers by path, with their headers
        self.overdue: list[str] = []  # paths of answers that were held a minute, in vain
        self._holding: dict[str, str] = {}
        self._cutting: dict[str, int] = {}
        self._news = threading.Condition()

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}"

    def hold(self, answer: str, until: str) -> None:
        """Hold back the answer for a path that has `answer` in it until one with `until` in it has been asked for."""
        self._holding[answer] = until

    def cut(self, answer: str, after: int) -> None:
        """Close the connection of the first answer for a path that has `answer` in it, after so many bytes."""
        self._cutting[answer] = after

    def cuts(self, path: str) -> bool:
        """Return whether the connection of an answer for the path is to be closed now; once."""
        due = [answer for answer, after in self._cutting.items() if answer in path and self.received[path] > after]
        for answer in due:
            del self._cutting[answer]
        return bool(due)

    def note(self, path: str) -> None:
        with self._news:
            self.requests.append(path)
            self._news.notify_all()

    def release(self, path: str) -> None:
        """Return when an answer for the path may go on."""
        with self._news:
            for answer, until in self._holding.items():
                if answer in path and not self._news.wait_for(lambda u=until: any(u in p for p in self.requests), 60):
                    self.overdue.append(path)


class _Connection(socketserver.BaseRequestHandler):
    server: Relay

    def handle(self) -> None:
        path = ""
        with socket.create_connection(self.server.server) as upstream:
            down = threading.Thread(target=self._pump_down, args=(upstream, lambda: path), daemon=True)
            down.start()
            while data := _receive(self.request):
                for match in _REQUEST.finditer(data):
                    path = match[1].decode()
                    self.server.note(path)
                upstream.sendall(data)
            upstream.shutdown(socket.SHUT_RDWR)
            down.join()

    def _pump_down(self, upstream: socket.socket, path) -> None:  # type: ignore[no-untyped-def]
        while data := _receive(upstream):
            self.server.release(path())
            self.server.received[path()] += len(data)
            if self.server.cuts(path()):
                self.request.shutdown(socket.SHUT_RDWR)
                return
            try:
                self.request.sendall(data)
            except OSError:
                return


def _receive(connection: socket.socket) -> bytes:
    try:
        return connection.recv(65536)
    except OSError:
        return b""


@contextmanager
def relayed(server: str) -> Iterator[Relay]:
    """Run a relay to a server's address (http://host:port) within this context."""
    host, _, port = server.removeprefix("http://").partition(":")
    with Relay((host, int(port))) as relay:
        thread = threading.Thread(target=relay.serve_forever, daemon=True)
        thread.start()
        try:
            yield relay
        finally:
            relay.shutdown()
            thread.join()
