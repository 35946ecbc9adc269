"""When a scene's segments are shown, in seconds and in their own time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hgs_core.base.errors import InputError
from hgs_core.codec.encoder.encode_dynamic import SegmentTime
from hgs_core.scene.splats import HybridScene, Segment

__all__ = ["Shown", "frame_interval", "shown_segments"]

STILL_FRAME_RATE = 30.0  # stated for a capture of one frame, which has none


@dataclass(frozen=True)
class Shown:
    """A segment, its number, until when it is shown (seconds), and the seconds between the capture's frames."""

    segment: Segment[NDArray[np.float32]]
    number: int
    until: float
    interval: float

    @property
    def frame(self) -> float:
        """The interval between frames in normalised time; 1 in a segment of no length."""
        length = self.segment.end - self.segment.start
        return self.interval / length if length > 0 else 1.0

    @property
    def time(self) -> SegmentTime:
        """The segment's clock."""
        return SegmentTime(self.segment.start, self.segment.end, self.segment.normalised(self.until))


def frame_interval(times: NDArray[np.float64]) -> float:
    """Return the seconds between a capture's frames [F].

    Raises:
        InputError: the times do not increase.
    """
    if times.ndim != 1 or len(times) == 0 or not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise InputError("times", "are not increasing seconds", "give the capture's clock")
    return float(np.median(np.diff(times))) if len(times) > 1 else 1 / STILL_FRAME_RATE


def shown_segments(scene: HybridScene[NDArray[np.float32]], interval: float) -> list[Shown]:
    """Return the segments of a scene: each is shown until the next one starts.

    Raises:
        InputError: there are none, or they are not in order of time.
    """
    starts = [segment.start for segment in scene.segments]
    if not starts or sorted(starts) != starts or any(s.end < s.start for s in scene.segments):
        raise InputError("scene.segments", "are not in order of time", "train the scene again")
    ends = [*starts[1:], scene.segments[-1].end]
    return [
        Shown(segment, i, until, interval) for i, (segment, until) in enumerate(zip(scene.segments, ends, strict=True))
    ]
