"""Axes: from values to places, and ticks at round numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["Axis", "linear_axis", "tick_text", "ticks_within"]

_STEP_ROUNDING = 1e-9  # share of a step


@dataclass(frozen=True)
class Axis:
    """A linear map from [low, high] to [start, end] (user units; start may be the larger), and its ticks."""

    low: float
    high: float
    start: float
    end: float
    step: float  # between ticks

    def __call__(self, value: float) -> float:
        """Return the place of a value."""
        return self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)

    @property
    def ticks(self) -> list[tuple[float, str]]:
        """Return the values of the ticks, ascending, and their words."""
        return [(value, tick_text(value, self.step)) for value in ticks_within(self.low, self.high, self.step)]


def linear_axis(
    values: Iterable[float], start: float, end: float, *, zero: bool = False, tight: bool = False, count: int = 5
) -> Axis:
    """Return an axis over all finite `values` with about `count` intervals.

    Args:
        values: to be shown; with none of them finite the axis goes from 0 to 1.
        start: the place of the low end.
        end: the place of the high end.
        zero: the axis begins at zero or below.
        tight: the axis ends at the largest value instead of at a tick.
        count: wish for the number of intervals.
    """
    finite = [value for value in values if math.isfinite(value)] or [0.0, 1.0]
    low, high = min(finite), max(finite)
    if zero:
        low, high = min(low, 0.0), max(high, 0.0)
    if high - low <= 1e-6 * max(abs(low), abs(high)):
        margin = 0.02 * abs(high) or 0.5
        low, high = (low if zero else low - margin), high + margin
    step = round_step((high - low) / count)
    bottom = math.floor(low / step + _STEP_ROUNDING) * step
    top = high if tight else math.ceil(high / step - _STEP_ROUNDING) * step
    return Axis(bottom, top, start, end, step)


def round_step(rough: float) -> float:
    """Return 1, 2 or 5 times a power of ten: the smallest that is not below `rough`."""
    power = 10.0 ** math.floor(math.log10(rough))
    return next((m * power for m in (1, 2, 5) if m * power >= rough * (1 - _STEP_ROUNDING)), 10 * power)


def ticks_within(low: float, high: float, step: float) -> list[float]:
    """Return the multiples of `step` from `low` to `high`, ascending."""
    first, last = math.ceil(low / step - _STEP_ROUNDING), math.floor(high / step + _STEP_ROUNDING)
    return [k * step for k in range(first, last + 1)]


def tick_text(value: float, step: float) -> str:
    """Return a tick's number with the decimals that its step needs; thousands as k, millions as M."""
    for size, letter in ((1e6, "M"), (1e3, "k")):
        if abs(value) >= size and step * 10 >= size:
            return f"{value / size:g}{letter}"
    decimals = max(0, -math.floor(math.log10(step) + _STEP_ROUNDING))
    return f"{value + 0.0:.{decimals}f}"
