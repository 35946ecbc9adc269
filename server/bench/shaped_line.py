"""A line of a given rate to a server on this machine, for measuring: a relay with next to no buffer of its own."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import time
from collections.abc import Callable

__all__ = ["LineClock", "ShapedLine"]

PIECE = 2048  # bytes that are relayed at once
QUEUE = 16 << 10  # bytes, about, that wait in the relay
LONGEST_BURST = 0.01  # seconds of an idle line that may be made up for: a machine is late before it sends, too


class LineClock:
    """The clock of a line that carries one message after the other; moments in seconds of any clock."""

    def __init__(self, now: float) -> None:
        self._free = now  # moment at which the line is free

    def carry(self, size: int, rate: float, now: float, *, idle: bool) -> float:
        """Return when so many bytes have passed at `rate` bits per second; whether the line was `idle` before them.

        If it was not, they have been held up by this machine alone, which is made up for.
        """
        begin = max(self._free, now - LONGEST_BURST) if idle else self._free
        self._free = begin + 8 * size / rate
        return self._free


class ShapedLine:
    """A relay to a port of this machine; bytes from there pass at `rate` bits per second."""

    def __init__(self, port: int, rate: Callable[[float], float]) -> None:
        """Take the rate from a function of the seconds since the line was opened; 0 lets nothing through."""
        self._port, self._rate = port, rate
        self._relays: set[asyncio.Task[None]] = set()
        self.passed = 0  # bytes
        self.address = ""

    async def __aenter__(self) -> ShapedLine:
        """Open the line; `address` is its end for clients."""
        self._begun = time.monotonic()
        self._clock = LineClock(self._begun)
        self._server = await asyncio.start_server(self._connected, "127.0.0.1", 0)
        host, port = self._server.sockets[0].getsockname()
        self.address = f"{host}:{port}"
        return self

    async def __aexit__(self, *_: object) -> None:
        """Close it, with all connections."""
        self._server.close()
        for relay in self._relays:
            relay.cancel()
        await asyncio.gather(*self._relays, return_exceptions=True)

    def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        relay = asyncio.create_task(self._relay(reader, writer))
        self._relays.add(relay)
        relay.add_done_callback(self._relays.discard)

    async def _relay(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.closing(writer), contextlib.suppress(OSError):
            inner = socket.socket()
            inner.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, QUEUE // 2)  # the kernel takes twice that
            inner.setblocking(False)
            await asyncio.get_running_loop().sock_connect(inner, ("127.0.0.1", self._port))
            upstream, request = await asyncio.open_connection(sock=inner, limit=PIECE)
            with contextlib.closing(request):
                asks = asyncio.create_task(self._ask(reader, request))
                try:
                    await self._answer(upstream, writer)
                finally:
                    asks.cancel()
                    await asyncio.gather(asks, return_exceptions=True)

    async def _ask(self, reader: asyncio.StreamReader, request: asyncio.StreamWriter) -> None:
        while piece := await reader.read(PIECE):
            request.write(piece)
            await request.drain()
        request.close()

    async def _answer(self, upstream: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while True:
            reading = asyncio.ensure_future(upstream.read(PIECE))
            await asyncio.sleep(0)
            idle = not reading.done()
            if not (piece := await reading):
                return
            while (rate := self._rate(time.monotonic() - self._begun)) <= 0:
                await asyncio.sleep(0.01)
                idle = True
            now = time.monotonic()
            if (wait := self._clock.carry(len(piece), rate, now, idle=idle) - now) > 0:
                await asyncio.sleep(wait)
            self.passed += len(piece)
            writer.write(piece)
            await writer.drain()
