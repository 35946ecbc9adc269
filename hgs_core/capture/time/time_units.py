"""The unit of time stamps: as a column says it, or as steps from frame to frame tell it.

Pictures come at rates that people know, so that a step tells its unit: at 30 per second it is 0.033 in seconds, 33 in
milliseconds, 33,333 in microseconds. What lies between two units is nobody's, and refused where it is read.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

__all__ = ["SECONDS", "UNITS", "TimeUnit", "unit_in_name", "unit_of_step"]

_NEAR = 2.0  # times the known rate or its inverse: videos state rates that they were not recorded at
_SLOWEST, _FASTEST = 5.0, 250.0  # pictures per second, where nothing states their rate


@dataclass(frozen=True)
class TimeUnit:
    """A unit of time."""

    name: str
    per_second: float
    words: frozenset[str]  # names of it in columns


SECONDS = TimeUnit("seconds", 1.0, frozenset(("s", "sec", "secs", "second", "seconds")))

UNITS = (
    SECONDS,
    TimeUnit("milliseconds", 1e3, frozenset(("ms", "msec", "msecs", "millis", "millisecond", "milliseconds"))),
    TimeUnit(
        "microseconds", 1e6, frozenset(("us", "µs", "μs", "usec", "usecs", "micros", "microsecond", "microseconds"))
    ),
    TimeUnit("nanoseconds", 1e9, frozenset(("ns", "nsec", "nsecs", "nanos", "nanosecond", "nanoseconds"))),
)


def unit_in_name(column: str) -> tuple[str, TimeUnit | None]:
    """Return the name of a column as names are compared, and the unit that it ends with.

    "Frame Time (ms)" and "frameTime_ms" are "frame_time" and milliseconds.
    """
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", column)
    parts = [part for part in re.split(r"[^a-z0-9µμ]+", words.lower()) if part]
    unit = next((one for one in UNITS if parts and parts[-1] in one.words), None)
    return "_".join(parts if unit is None else parts[:-1]), unit


def unit_of_step(step: float, rate: float | None) -> TimeUnit | None:
    """Return the unit in which `step` is the time from frame to frame.

    `rate` is that of the pictures, per second; None: nothing states it, and what no other unit explains is seconds.
    """
    low, high = (_SLOWEST, _FASTEST) if rate is None else (rate / _NEAR, rate * _NEAR)
    for unit in UNITS:
        if step > 0 and low <= unit.per_second / step <= high:
            return unit
    return SECONDS if rate is None and 0 < step < UNITS[1].per_second / _FASTEST else None
