"""Credit and pace: how many bytes of chunk frames a client has room for, and when its line takes more.

docs/protocol.md, section "Messages of the client": `credit` and `limits`. No socket, no clock.
"""

from __future__ import annotations

import math

from server.protocol.messages import HEADER_BYTES, MAX_BALANCE, MAX_PAYLOAD, MIN_PAYLOAD, ProtocolError

__all__ = ["FlowControl"]

PACE_SECONDS = 0.125  # of a limited rate that go at once
SHORT_PAYLOAD = 16 << 10  # bytes of a frame on a line that is slow, or not known: a fourth of the smallest window
FAST = 1e6  # bytes per second of a line that carries the longest frame in some hundredths of a second
UNKNOWN_BYTES = 256 << 10  # after which a line of which nothing was told is taken to be fast


class FlowControl:
    """What one client may be sent, frame by frame."""

    def __init__(self) -> None:
        self.bytes_per_second: float | None = None  # that the client wants at most; None: any
        self.measured: float | None = None  # bytes per second that the line brings; None: not known
        self.balance = 0  # bytes of chunk frames that the client has room for
        self.sent_bytes = 0  # of chunks, without the frames' headers
        self._next_frame = -math.inf  # when the client takes more; seconds of the caller's clock

    def grant(self, amount: int) -> None:
        """Add credit of so many bytes.

        Raises:
            ProtocolError: 4009, the balance would rise above `MAX_BALANCE`.
        """
        if self.balance + amount > MAX_BALANCE:
            raise ProtocolError(4009, "credit-overflow", f"the balance would rise above {MAX_BALANCE} bytes")
        self.balance += amount

    def wait(self, clock: float) -> float | None:
        """Return the seconds until the pace allows another frame, None if it does now."""
        return self._next_frame - clock if clock < self._next_frame else None

    def spend(self, rest: int, clock: float) -> int | None:
        """Pay for the next frame of a chunk with `rest` bytes to go; return its bytes, None without the credit.

        A client gives credit back when a frame is whole: were one as long as its window, the line would lie idle for a
        round trip after each, and a seek would wait for the whole of it.
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
        """Take back what was paid for a frame of so many bytes that is not sent after all."""
        self.balance += HEADER_BYTES + length
        self.sent_bytes -= length
