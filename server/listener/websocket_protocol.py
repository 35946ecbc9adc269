"""WebSockets under uvicorn, for slow connections and for peers that stop reading or never stop writing."""

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

UNSENT_BYTES = 32 << 10  # unsent data in the kernel: a seek waits for no more
STALL_SECONDS = 45.0  # a peer that reads nothing for this long is cut off
STALL_CHECKS = 15  # checks within `STALL_SECONDS`; a peer is cut off one check early rather than late
PIECE_BYTES = 4 << 10  # parsed at a time, so that no peer's messages fill the memory
MAX_FRAGMENTS = 1024  # fragments per message
PING_RATE = 10.0  # WebSocket pings per second
PING_BURST = 100.0
RESET_ON_CLOSE = struct.pack("ii", 1, 0)  # struct linger


class WebSocketProtocol(WebSocketsSansIOProtocol):
    """Uvicorn's protocol, with little data in flight and a cut-off for unresponsive peers.

    It parses received data only as fast as the application takes messages. A peer is cut off, without a close, if it
    reads none of its pending data for `STALL_SECONDS`, less at most the time between two checks, if it neither sends
    anything nor answers a keepalive ping in uvicorn's time, or if it floods with pings or fragments.
    """

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        self._unparsed = bytearray()
        self._pings = TokenBucket(PING_RATE, PING_BURST)
        self._heard = False  # received anything since the last keepalive check
        self._taken_at: float | None = None  # last time the peer read pending data, or earlier; None: no pending data
        self._waiting = 0  # pending bytes at the last check; 0: not checked since the buffer was empty
        self._looked_at = 0.0
        self._stall_timer: TimerHandle | None = None

    def connection_made(self, transport: BaseTransport) -> None:
        """Keep little data in flight: a seek cannot overtake bytes that have been handed over."""
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
        """Pause writers, and check at intervals whether the peer reads its pending data."""
        super().pause_writing()
        self._taken_at, self._waiting = self.loop.time(), 0
        if self._stall_timer is None:
            self._look_again()

    def resume_writing(self) -> None:
        """Record that nothing is pending."""
        self._taken_at = None
        super().resume_writing()

    def handle_ping(self) -> None:
        """Answer, unless pings come too fast."""
        if self._pings.spend(1, self.loop.time()) > 0:
            self._cut_off("it floods with pings")
        else:
            super().handle_ping()

    def handle_cont(self, event: Frame) -> None:
        """Assemble a message, unless it has too many fragments."""
        if len(self.frames) >= MAX_FRAGMENTS:
            self._cut_off("it floods with fragments")
        else:
            super().handle_cont(event)

    def keepalive_timeout(self) -> None:
        """Cut off a silent peer, unless the ping may still be queued behind data or the peer has sent something."""
        if self._heard or self.transport.get_write_buffer_size() > 0:
            self._heard = False
            self.pong_timer = self.loop.call_later(self.ping_timeout or STALL_SECONDS, self.keepalive_timeout)
        else:
            self._cut_off("it does not answer pings")

    def _parse(self) -> None:
        while self._unparsed and not self.read_paused and not self.transport.is_closing():
            piece = bytes(self._unparsed[:PIECE_BYTES])
            del self._unparsed[:PIECE_BYTES]
            super().data_received(piece)

    def _look_again(self) -> None:
        self._looked_at = self.loop.time()
        self._stall_timer = self.loop.call_later(STALL_SECONDS / STALL_CHECKS, self._look)

    def _look(self) -> None:
        """Check whether the pending data has shrunk; only pings add to it while writers wait."""
        self._stall_timer = None
        if self._taken_at is None:
            return
        waiting = self.transport.get_write_buffer_size()
        if waiting < self._waiting:
            self._taken_at = max(self._taken_at, self._looked_at)
        self._waiting = waiting
        # The next check would be too late.
        if self.loop.time() - self._taken_at > STALL_SECONDS - STALL_SECONDS / STALL_CHECKS:
            self._cut_off(f"it has read nothing for {STALL_SECONDS:g} s")
        else:
            self._look_again()

    def _cut_off(self, reason: str) -> None:
        """Close at once and drop unsent data, in the kernel too, where it would wait for the peer."""
        log.info("cut off the WebSocket of %s: %s", self.client, reason)
        self._set_option(socket.SOL_SOCKET, socket.SO_LINGER, RESET_ON_CLOSE)
        self.transport.abort()

    def _set_option(self, level: int, option: int, value: int | bytes) -> None:
        connection = self.transport.get_extra_info("socket")
        if connection is not None and connection.family in (socket.AF_INET, socket.AF_INET6):
            connection.setsockopt(level, option, value)
