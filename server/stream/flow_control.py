"""Credit and pacing of chunk frames.

docs/stream.md, section "Messages of the client": `credit` and `limits`. No socket, no clock.
"""

from __future__ import annotations

import math

from server.protocol.messages import HEADER_BYTES, MAX_BALANCE, MAX_PAYLOAD, MIN_PAYLOAD, ProtocolError
from server.protocol.stream_endings import Closing

__all__ = ["FlowControl"]

PACE_SECONDS = 0.125  # share of a limited rate sent in one burst
SHORT_PAYLOAD = 16 << 10  # bytes of a frame on a slow or unmeasured connection: a quarter of the smallest window
FAST = 1e6  # bytes per second at which the longest frame takes some hundredths of a second
UNKNOWN_BYTES = 256 << 10  # bytes after which an unmeasured connection counts as fast


class FlowControl:
    """Send budget of one client, frame by frame."""

    def __init__(self) -> None:
        self.bytes_per_second: float | None = None  # the client's limit; None: any rate
        self.measured: float | None = None  # measured throughput, bytes per second; None: unknown
        self.balance = 0  # credit in bytes of chunk frames
        self.sent_bytes = 0  # bytes of chunks, without frame headers
        self._next_frame = -math.inf  # earliest time of the next frame, seconds of the caller's clock

    def grant(self, amount: int) -> None:
        """Add credit of `amount` bytes.

        Raises:
            ProtocolError: 4009, the balance would rise above `MAX_BALANCE`.
        """
        if self.balance + amount > MAX_BALANCE:
            raise ProtocolError(Closing.CREDIT_OVERFLOW, f"the balance would rise above {MAX_BALANCE} bytes")
        self.balance += amount

    def wait(self, clock: float) -> float | None:
        """Return the seconds until the pace allows another frame; None if it does now."""
        return self._next_frame - clock if clock < self._next_frame else None

    def spend(self, rest: int, clock: float) -> int | None:
        """Pay for the next frame of a chunk with `rest` bytes left; return its length, or None without credit.

        A client returns credit when a frame is complete: a frame as long as its window would leave the connection idle
        for a round trip, and a seek would wait for all of it.
        """
        pace = self.bytes_per_second
        fast = self.sent_bytes >= UNKNOWN_BYTES if self.measured is None else self.measured >= FAST
        most = MAX_PAYLOAD if fast else SHORT_PAYLOAD
        if pace is not None:
            most = min(most, max(MIN_PAYLOAD, int(pace * PACE_SECONDS)))
        length = min(rest, most, self.balance - HEADER_BYTES)
        if length < min(rest, MIN_PAYLOAD):
            return None
        self.balance -= HEADER_BYTES + length
        self.sent_bytes += length
        if pace is not None:
            self._next_frame = max(self._next_frame, clock - PACE_SECONDS) + (HEADER_BYTES + length) / pace
        return length

    def refund(self, length: int) -> None:
        """Refund a frame of `length` bytes that is not sent after all."""
        self.balance += HEADER_BYTES + length
        self.sent_bytes -= length
