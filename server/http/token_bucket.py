"""A token bucket, to limit the rate of a client's requests."""

from __future__ import annotations

__all__ = ["TokenBucket"]


class TokenBucket:
    """A bucket of at most `capacity` tokens, full at first, that gains `rate` tokens per second."""

    def __init__(self, rate: float, capacity: float) -> None:
        self._rate = rate
        self._capacity = capacity
        self._tokens = capacity
        self._clock: float | None = None

    def earn(self, tokens: float) -> None:
        """Add tokens, up to the capacity."""
        self._tokens = min(self._capacity, self._tokens + tokens)

    def spend(self, tokens: float, clock: float) -> float:
        """Take tokens at the moment `clock`, in seconds of any monotonic clock; return the seconds to wait.

        The wait is 0 while the bucket holds enough tokens; otherwise it is the time until the debt is repaid.
        """
        if self._clock is not None:
            self.earn(self._rate * (clock - self._clock))
        self._clock = clock
        self._tokens -= tokens
        return max(0.0, -self._tokens / self._rate)
