"""The client's playhead, extrapolated between its messages."""

from __future__ import annotations

from dataclasses import dataclass

from server.protocol.messages import DEFAULT_RATE

__all__ = ["Playhead"]


@dataclass
class Playhead:
    """Playhead of a looping player, by dead reckoning from its last message; at the end of a growing scene it waits."""

    start: float  # seconds, as the end: the scene's interval
    end: float
    time: float  # position at the moment `clock`
    clock: float = 0.0  # seconds of the caller's monotonic clock
    rate: float = DEFAULT_RATE  # scene seconds per second
    grows: bool = False

    def set(self, time: float, clock: float, rate: float | None = None) -> None:
        """Move to `time`, clamped to the scene."""
        self.time = min(max(time, self.start), self.end)
        self.clock = clock
        self.rate = self.rate if rate is None else rate

    def at(self, clock: float) -> float:
        """Return the position at the moment `clock`, in scene seconds, wrapped at the end."""
        time = self.time + self.rate * max(clock - self.clock, 0.0)
        if time <= self.end:
            return time
        if self.grows:
            return self.end
        duration = self.end - self.start
        return self.start + (time - self.start) % duration if duration > 0 else self.start
