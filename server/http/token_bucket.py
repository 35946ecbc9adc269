"""How often a client may ask: a token bucket."""

from __future__ import annotations

__all__ = ["TokenBucket"]


class TokenBucket:
    """Holds at most `capacity` tokens, is full at first, and gains `rate` tokens per second."""

    def __init__(self, rate: float, capacity: float) -> None:
        self._rate = rate
        self._capacity = capacity
        self._tokens = capacity
        self._clock: float | None = None

    def earn(self, tokens: float) -> None:
        """Put tokens in; what does not fit is lost."""
        self._tokens = min(self._capacity, self._tokens + tokens)

    def spend(self, tokens: float, clock: float) -> float:
        """Take tokens at the moment `clock`, in seconds of any monotonic clock; return how long to wait, in seconds.

        The wait is 0 while the bucket has what is asked; else it is the time until the debt is paid.
        """
        if self._clock is not None:
            self.earn(self._rate * (clock - self._clock))
        self._clock = clock
        self._tokens -= tokens
        return max(0.0, -self._tokens / self._rate)
