"""Cutting a capture into segments: they share the statics, and each has dynamics of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from hgs_core.points.point_cloud import PointCloud
from hgs_core.scene.splats import DynamicSplats, Segment

__all__ = ["CaptureSegment", "cut_into_segments"]


@dataclass(frozen=True)
class CaptureSegment:
    """A stretch of consecutive frames of a capture."""

    first: int  # frame
    frames: int
    end: int  # frame at which its time ends: the next segment's first, or the capture's last
    clock: Segment[npt.NDArray[np.float32]]  # its stretch of time, without splats

    @property
    def seconds(self) -> float:
        """How long it is."""
        return self.clock.end - self.clock.start

    def sampled(self, every: int) -> Sequence[int]:
        """Return its first and last frame and some between, ascending, spread evenly and at most `every` apart."""
        gaps = -(-(self.end - self.first) // every)
        return sorted({round(frame) for frame in np.linspace(self.first, self.end, gaps + 1)})

    def points(self, cloud: PointCloud) -> PointCloud:
        """Return the points that were seen in this segment; static points are in all of them."""
        inside = (cloud.times >= np.float32(self.clock.start)) & (cloud.times <= np.float32(self.clock.end))
        return cloud.take(inside | (cloud.dynamic == 0))


def cut_into_segments(times: npt.NDArray[np.float64], longest: int) -> Sequence[CaptureSegment]:
    """Cut frames at `times` [F] (seconds) into the fewest segments of at most `longest` frames, of about equal length.

    A segment's time ends where the next one starts, the last one's with the last frame.
    """
    count = -(-len(times) // longest)
    borders = [len(times) * i // count for i in range(count)] + [len(times) - 1]
    return [
        CaptureSegment(
            first,
            (last if i + 1 < count else len(times)) - first,
            last,
            Segment(float(times[first]), float(times[last]), DynamicSplats.empty()),
        )
        for i, (first, last) in enumerate(pairwise(borders))
    ]
