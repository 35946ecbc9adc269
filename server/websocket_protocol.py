"""WebSockets under uvicorn, for lines that are slow and for peers that stop reading or never stop writing."""

from __future__ import annotations

import logging
import socket
import struct
from asyncio import BaseTransport, TimerHandle
from typing import Any

from uvicorn._types import ASGIReceiveEvent
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame

from server.token_bucket import TokenBucket

__all__ = ["WebSocketProtocol"]

log = logging.getLogger("hgs.server")

UNSENT_BYTES = 32 << 10  # that the kernel takes beyond what is on its way: a seek waits for no more
STALL_SECONDS = 45.0  # of taking nothing, after which a peer is cut off
STALL_CHECKS = 15  # looks at the buffer in this time
PIECE_BYTES = 4 << 10  # that are parsed at once: no peer's messages fill the memory before they are dealt with
MAX_FRAGMENTS = 1024  # of one message
PING_RATE = 10.0  # WebSocket pings per second
PING_BURST = 100.0
RESET_ON_CLOSE = struct.pack("ii", 1, 0)  # struct linger


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """Uvicorn's protocol, which keeps little data in flight and cuts off whom waiting does not help.

    It parses what it has read only as fast as the application takes messages. A peer is cut off, without a close, if it
    takes none of what waits for it for about `STALL_SECONDS`, if it neither sends anything nor answers a keepalive
    ping in uvicorn's time, or if it floods with pings or fragments, which no browser sends.
    """

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._unparsed = bytearray()
        self._pings = TokenBucket(PING_RATE, PING_BURST)
        self._heard = False  # since the last look at the keepalive
        self._taken = True  # whether the peer has taken all that waited, since the last look at the buffer
        self._waiting = 0  # bytes in the buffer at the last look
        self._stalled = 0  # looks in a row at which the peer had taken nothing
        self._stall_timer: TimerHandle | None = None

    def connection_made(self, transport: BaseTransport) -> None:
        """Keep what is in flight small: bytes that have been handed over cannot be overtaken by those of a seek."""
        super().connection_made(transport)
        self.transport.set_write_buffer_limits(high=0)
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            self._set_option(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_BYTES)
        self._watch_stall()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop watching."""
        if self._stall_timer is not None:
            self._stall_timer.cancel()
        self._unparsed.clear()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Parse as much as the application is ready for."""
        self._heard = True
        self._unparsed += data
        self._parse()

    async def receive(self) -> ASGIReceiveEvent:
        """Return the next event, and make the one after it ready."""
        event = await super().receive()
        self._parse()
        return event

    def resume_writing(self) -> None:
        """Note that nothing waits any more."""
        self._taken = True
        super().resume_writing()

    def handle_ping(self) -> None:
        """Answer, unless pings come too fast."""
        if self._pings.spend(1, self.loop.time()) > 0:
            self._cut_off("it floods with pings")
        else:
            super().handle_ping()

    def handle_cont(self, event: Frame) -> None:
        """Put a message together, unless it has too many parts."""
        if len(self.frames) >= MAX_FRAGMENTS:
            self._cut_off("it floods with fragments")
        else:
            super().handle_cont(event)

    def keepalive_timeout(self) -> None:
        """Cut off a silent peer, but wait on where the ping may still stand behind data, or the peer speaks."""
        if self._heard or self.transport.get_write_buffer_size() > 0:
            self._heard = False
            self.pong_timer = self.loop.call_later(self.ping_timeout or STALL_SECONDS, self.keepalive_timeout)
        else:
            self._cut_off("it answers no ping")

    def _parse(self) -> None:
        while self._unparsed and not self.read_paused and not self.transport.is_closing():
            piece = bytes(self._unparsed[:PIECE_BYTES])
            del self._unparsed[:PIECE_BYTES]
            super().data_received(piece)

    def _watch_stall(self) -> None:
        """Look regularly whether what waits for the peer becomes less; writers wait while there is any."""
        waiting = self.transport.get_write_buffer_size()
        self._stalled = self._stalled + 1 if 0 < self._waiting <= waiting and not self._taken else 0
        self._waiting, self._taken = waiting, False
        if self._stalled >= STALL_CHECKS:
            self._cut_off(f"it has taken nothing for {STALL_SECONDS:g} s")
        else:
            self._stall_timer = self.loop.call_later(STALL_SECONDS / STALL_CHECKS, self._watch_stall)

    def _cut_off(self, reason: str) -> None:
        """Close at once and drop what was to be sent, in the kernel too, for it would wait there for the peer."""
        log.info("cut off the WebSocket of %s: %s", self.client, reason)
        self._set_option(socket.SOL_SOCKET, socket.SO_LINGER, RESET_ON_CLOSE)
        self.transport.abort()

    def _set_option(self, level: int, option: int, value: int | bytes) -> None:
        connection = self.transport.get_extra_info("socket")
        if connection is not None and connection.family in (socket.AF_INET, socket.AF_INET6):
            connection.setsockopt(level, option, value)
