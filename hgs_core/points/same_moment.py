"""Groups of cameras with pictures of one moment: cameras out of step film moving things at different places.

A point that moves by twenty pixels in a frame is ten pixels away half a frame later: triangulated from cameras half a
frame apart it stands at a wrong place, or nowhere. So what moves is taken from cameras that are nearly in step with
each other, group by group, each at its own time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hgs_core.capture.capture import Capture

__all__ = ["SameMoment", "same_moments"]

_IN_STEP = 0.1  # share of a frame; cameras off the clock by less count as in step
_WINDOWS = (0.2, 0.35, 0.5)  # widths of a group in frames, the narrowest first; beyond these all are one group
_FEWEST = 3  # cameras that prove a point


@dataclass(frozen=True)
class SameMoment:
    """Pictures taken at about one time."""

    seconds: float  # their mean time
    cameras: tuple[int, ...]  # indices into the capture's cameras
    frames: tuple[int, ...]  # frames of these cameras


def same_moments(capture: Capture, cameras: Sequence[int], frame: int) -> list[SameMoment]:
    """Return groups of cameras with the frames, near `frame`, that they took at about the same time.

    Cameras in step are one group. Of others, groups of three or more that are nearly in step; a camera that is in none
    is left out, unless there is no group at all: then all are one.
    """
    tick = float(capture.times[frame])
    whole = [SameMoment(tick, tuple(cameras), (frame,) * len(cameras))]
    if len(capture.times) < 2:
        return whole
    period = float(np.median(np.diff(capture.times)))
    phases = np.array([(capture.moment(index, frame) - tick) / period for index in cameras])  # -0.5 to 0.5
    if (np.abs(phases) <= _IN_STEP).all():
        return whole
    for width in _WINDOWS:
        groups = _groups(phases, width)
        if groups:
            return sorted((_moment(capture, cameras, frame, rows) for rows in groups), key=lambda one: one.seconds)
    return whole


def _groups(phases: np.ndarray, width: float) -> list[list[tuple[int, int]]]:
    """Return groups of (row, frames to go on), the largest first; the phases go round: half a frame late is early."""
    left, found = set(range(len(phases))), []
    while len(left) >= _FEWEST:
        windows = []
        for first in sorted(left):
            begin = float(phases[first])
            inside = []
            for row in sorted(left):
                ahead = int(np.ceil(begin - 1e-9 - phases[row]))  # frames on, at which it is the next after `begin`
                if phases[row] + ahead - begin <= width + 1e-9:
                    inside.append((row, ahead))
            windows.append(inside)
        best = max(windows, key=len)
        if len(best) < _FEWEST:
            break
        found.append(best)
        left -= {row for row, _ in best}
    return found


def _moment(capture: Capture, cameras: Sequence[int], frame: int, rows: Sequence[tuple[int, int]]) -> SameMoment:
    last = len(capture.times) - 1
    steps = [ahead for _, ahead in rows]
    back = 1 if np.mean(steps) > 0.5 else 0  # most of them are a frame on: go back a frame instead
    if not all(0 <= frame + ahead - back <= last for ahead in steps):
        back = 0 if frame + max(steps) <= last else max(steps)
    frames = [int(np.clip(frame + ahead - back, 0, last)) for ahead in steps]
    chosen = [cameras[row] for row, _ in rows]
    times = [capture.moment(index, own) for index, own in zip(chosen, frames, strict=True)]
    seconds = float(np.clip(np.mean(times), capture.times[0], capture.times[-1]))
    return SameMoment(seconds, tuple(chosen), tuple(frames))
