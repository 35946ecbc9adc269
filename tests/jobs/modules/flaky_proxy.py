"""A TCP proxy in front of a server that shall be away for a while, or far: answers fail, come late or not at all."""

from __future__ import annotations

import contextlib
import socket
import threading
import time


class FlakyProxy:
    """Passes everything on to a port of this machine, until it is told to refuse connections or to let them hang."""

    def __init__(self, port: int, host: str = "127.0.0.1") -> None:
        self._target = port
        self._host = host
        self._hanging = False
        self._late = 0.0  # seconds
        self._open: set[socket.socket] = set()
        self._listener = self._listen(0)
        self.port = self._listener.getsockname()[1]
        self.address = f"http://127.0.0.1:{self.port}"

    def refuse(self) -> None:
        """Refuse new connections and break those that there are."""
        # A blocked accept keeps the socket listening after it is closed, unless it is shut down first.
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        self._break_all()

    def hang(self) -> None:
        """Take connections and everything that is sent, and answer nothing."""
        self._hanging = True
        self._break_all()

    def answer_late(self, seconds: float) -> None:
        """Bring every piece of an answer so much later."""
        self._late = seconds

    def drop(self) -> None:
        """Break the connections that there are."""
        self._break_all()

    def pass_on(self) -> None:
        """Work again."""
        self._late = 0.0
        if self._listener.fileno() < 0:
            self._listener = self._listen(self.port)
        elif self._hanging:
            self._hanging = False
            self._break_all()

    def _listen(self, port: int) -> socket.socket:
        listener = socket.create_server((self._host, port), backlog=128)
        threading.Thread(target=self._accept, args=(listener,), daemon=True).start()
        return listener

    def _accept(self, listener: socket.socket) -> None:
        while True:
            try:
                client, _ = listener.accept()
            except OSError:
                return
            self._open.add(client)
            if self._hanging:
                continue
            try:
                server = socket.create_connection(("127.0.0.1", self._target))
            except OSError:
                client.close()
                continue
            self._open.add(server)
            for source, sink, answers in ((client, server, False), (server, client, True)):
                threading.Thread(target=self._pump, args=(source, sink, answers), daemon=True).start()

    def _pump(self, source: socket.socket, sink: socket.socket, answers: bool) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(1 << 16):
                if answers and self._late:
                    time.sleep(self._late)
                sink.sendall(data)
        for end in (source, sink):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()
            self._open.discard(end)

    def _break_all(self) -> None:
        for end in list(self._open):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()
            self._open.discard(end)
