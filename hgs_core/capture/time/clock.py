"""One clock for cameras that each have their own time stamps.

The clock ticks at the rate that most cameras have, in step with the first of them. At every tick each camera shows the
frame that is nearest, at most half a period away; a tick at which a camera has none is left out. A frame that was not
taken right at its tick keeps its own time.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import counted

__all__ = ["CameraTime", "Clock", "common_clock", "mean_rate"]

_SAME_RATE = 1e-4  # share by which rates may differ and still count as one: 29.97 and 30 do not
_EXACT = 1e-6  # seconds: what numbers lose on the way
_LATE = 0.02  # share of a period; smaller differences from the tick need no note


@dataclass(frozen=True)
class CameraTime:
    """When the frames of a camera were taken."""

    name: str
    stamps: npt.NDArray[np.float64]  # [N] seconds, increasing
    rate: float  # frames per second
    tolerance: float = 0.0  # seconds by which stamps may err


def mean_rate(stamps: npt.NDArray[np.float64]) -> float:
    """Return the frame rate, per second, of stamps [N], 2 or more that increase, despite their rounding.

    Where steps are several times the usual one, so many frames are missing.
    """
    steps = np.diff(stamps)
    return float(np.maximum(1.0, np.round(steps / np.median(steps))).sum() / (stamps[-1] - stamps[0]))


@dataclass(frozen=True)
class Clock:
    """Which frame each camera shows at each tick."""

    times: npt.NDArray[np.float64]  # [F] seconds of the ticks, from 0
    frames: npt.NDArray[np.int64]  # [C, F] of the cameras' own numbers
    moments: npt.NDArray[np.float64]  # [C, F] seconds when those frames were taken
    notes: tuple[str, ...] = ()


def common_clock(where: object, cameras: Sequence[CameraTime]) -> Clock:
    """Return the clock of some cameras.

    Raises:
        InputError: the cameras have no moment in common, or a camera's stamps do not increase.
    """
    for camera in cameras:
        if len(camera.stamps) == 0 or (np.diff(camera.stamps) <= 0).any():
            raise InputError(where, f"the times of camera {camera.name} do not increase", "export its video again")
    rate = _usual_rate(cameras)
    leader = next(camera for camera in cameras if _same_rate(camera.rate, rate))
    period, origin = 1.0 / rate, float(leader.stamps[0])
    shown = [_nearest(camera, origin, period) for camera in cameras]
    common = sorted(set.intersection(*(set(numbers) for numbers in shown)))
    if not common:
        raise InputError(where, _apart(cameras), "check their time stamps, or write the offsets to sync.json")
    ticks = np.array(common, np.float64)
    frames = np.array([[numbers[tick] for tick in common] for numbers in shown], np.int64)
    start = common[0] * period
    times = (ticks - common[0]) * period
    moments = np.stack([camera.stamps[own] - origin - start for camera, own in zip(cameras, frames, strict=True)])
    for row, camera in zip(moments, cameras, strict=True):
        exact = np.abs(row - times) <= camera.tolerance + _EXACT
        row[exact] = times[exact]
    notes = _notes(cameras, rate, frames, moments - times, shown, common)
    return Clock(times, frames, moments, tuple(notes))


def _usual_rate(cameras: Sequence[CameraTime]) -> float:
    """Return the rate that most cameras have; of rates as frequent as each other the lower one."""
    groups: Counter[float] = Counter()
    for camera in cameras:
        known = next((rate for rate in groups if _same_rate(camera.rate, rate)), camera.rate)
        groups[known] += 1
    return min(groups, key=lambda rate: (-groups[rate], rate))


def _same_rate(first: float, second: float) -> bool:
    return abs(first / second - 1) <= _SAME_RATE


def _nearest(camera: CameraTime, origin: float, period: float) -> dict[int, int]:
    """Return the number of the camera's frame by tick: the nearest that is at most half a period away."""
    places = (camera.stamps - origin) / period
    ticks = np.round(places - 1e-9).astype(np.int64)  # the earlier tick for a frame half-way between two
    found: dict[int, int] = {}
    for frame, tick in enumerate(ticks.tolist()):
        before = found.get(tick)
        if before is None or abs(places[frame] - tick) < abs(places[before] - tick):
            found[tick] = frame
    return found


def _apart(cameras: Sequence[CameraTime]) -> str:
    spans = ", ".join(f"{c.name} {c.stamps[0]:.2f} to {c.stamps[-1]:.2f} s" for c in cameras[:8])
    return f"the cameras have no moment in common: {spans}"


def _notes(
    cameras: Sequence[CameraTime],
    rate: float,
    frames: npt.NDArray[np.int64],
    offsets: npt.NDArray[np.float64],
    shown: Sequence[dict[int, int]],
    common: Sequence[int],
) -> list[str]:
    """Return notes on omitted frames, and on cameras with frames off the ticks."""
    notes = []
    begins, ends = [min(numbers) for numbers in shown], [max(numbers) for numbers in shown]
    for word, limits, limit, way in (("begins", begins, max(begins), 1), ("ends", ends, min(ends), -1)):
        lost = way * (limit - (min(limits) if way > 0 else max(limits)))
        if lost > 0:
            by = ", ".join(c.name for c, place in zip(cameras, limits, strict=True) if place == limit)
            left = f"{counted(lost, 'moment')} of other cameras left out"
            notes.append(f"the capture {word} with {by}: {left}")
    inside = range(max(begins), min(ends) + 1)
    gaps = sorted(set(inside) - set(common))
    if gaps:
        short = [c.name for c, numbers in zip(cameras, shown, strict=True) if any(tick not in numbers for tick in gaps)]
        notes.append(
            f"{counted(len(gaps), 'moment')} of {len(inside)} left out, at which {', '.join(short)} has no frame"
        )
    other = [f"{c.name} {c.rate:.6g}" for c in cameras if not _same_rate(c.rate, rate)]
    if other:
        notes.append(f"most cameras have {rate:.6g} frames per second, and these have others: {', '.join(other)}")
    for camera, row, own in zip(cameras, offsets, frames, strict=True):
        worst = float(np.abs(row).max())
        if worst * rate > _LATE:
            notes.append(
                f"frames of {camera.name} are up to {worst * 1000:.1f} ms off the clock, and trained at their times"
            )
        unused = int(own[-1] - own[0] + 1 - len(own)) - len(gaps)
        if unused > 0:
            notes.append(f"{camera.name} has {counted(unused, 'frame')} too many, which are left out")
    return notes
