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

from server.http.token_bucket import TokenBucket

__all__ = ["WebSocketProtocol"]

log = logging.getLogger("hgs.server")

UNSENT_BYTES = 32 << 10  # that the kernel takes beyond what is on its way: a seek waits for no more
STALL_SECONDS = 45.0  # of taking nothing, in which a peer is cut off
STALL_CHECKS = 15  # looks at what waits for it in this time; it is cut off a look early rather than late
PIECE_BYTES = 4 << 10  # that are parsed at once: no peer's messages fill the memory before they are dealt with
MAX_FRAGMENTS = 1024  # of one message
PING_RATE = 10.0  # WebSocket pings per second
PING_BURST = 100.0
RESET_ON_CLOSE = struct.pack("ii", 1, 0)  # struct linger


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """Uvicorn's protocol, which keeps little data in flight and cuts off whom waiting does not help.

    It parses what it has read only as fast as the application takes messages. A peer is cut off, without a close, if it
    takes none of what waits for it for `STALL_SECONDS`, less at most the time between two looks, if it neither sends
    anything nor answers a keepalive ping in uvicorn's time, or if it floods with pings or fragments.
    """

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._unparsed = bytearray()
        self._pings = TokenBucket(PING_RATE, PING_BURST)
        self._heard = False  # since the last look at the keepalive
        self._taken_at: float | None = None  # when the peer last took of what waits, or earlier; None: nothing waits
        self._waiting = 0  # bytes in the buffer at the last look; 0: not looked at since it was empty
        self._looked_at = 0.0
        self._stall_timer: TimerHandle | None = None

    def connection_made(self, transport: BaseTransport) -> None:
        """Keep what is in flight small: bytes that have been handed over cannot be overtaken by those of a seek."""
        super().connection_made(transport)
        self.transport.set_write_buffer_limits(high=0)
        if hasattr(socket, "TCP_NOTSENT_LOWAT"):
            self._set_option(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_BYTES)

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

    def pause_writing(self) -> None:
        """Let writers wait, and look now and then whether the peer takes anything of what waits for it."""
        super().pause_writing()
        self._taken_at, self._waiting = self.loop.time(), 0
        if self._stall_timer is None:
            self._look_again()

    def resume_writing(self) -> None:
        """Note that nothing waits any more."""
        self._taken_at = None
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

    def _look_again(self) -> None:
        self._looked_at = self.loop.time()
        self._stall_timer = self.loop.call_later(STALL_SECONDS / STALL_CHECKS, self._look)

    def _look(self) -> None:
        """Find out whether what waits for the peer has become less; it grows by pings alone, as writers wait."""
        self._stall_timer = None
        if self._taken_at is None:
            return
        waiting = self.transport.get_write_buffer_size()
        if waiting < self._waiting:
            self._taken_at = max(self._taken_at, self._looked_at)
        self._waiting = waiting
        # At the next look it would be too late.
        if self.loop.time() - self._taken_at > STALL_SECONDS - STALL_SECONDS / STALL_CHECKS:
            self._cut_off(f"it has taken nothing for {STALL_SECONDS:g} s")
        else:
            self._look_again()

    def _cut_off(self, reason: str) -> None:
        """Close at once and drop what was to be sent, in the kernel too, for it would wait there for the peer."""
        log.info("cut off the WebSocket of %s: %s", self.client, reason)
        self._set_option(socket.SOL_SOCKET, socket.SO_LINGER, RESET_ON_CLOSE)
        self.transport.abort()

    def _set_option(self, level: int, option: int, value: int | bytes) -> None:
        connection = self.transport.get_extra_info("socket")
        if connection is not None and connection.family in (socket.AF_INET, socket.AF_INET6):
            connection.setsockopt(level, option, value)
