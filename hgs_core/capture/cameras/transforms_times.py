"""The times that frames of transforms.json have: shares of the whole, numbers of frames, or a unit of time.

Times from 0 to 1 are shares of the whole, as D-NeRF has them. Whole numbers are frames, unless they come in large steps
that the pictures' own numbers do not: then, and where they are not whole, their steps tell the unit.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from hgs_core.base.errors import InputError
from hgs_core.capture.cameras.transforms_file import Frame
from hgs_core.capture.time.time_units import SECONDS, unit_of_step

__all__ = ["FrameTimes", "frame_times"]

_LARGEST_STEP_OF_FRAMES = 7.0  # between pictures whose own numbers do not confirm it; 8 ms are 125 per second
_LAST_NUMBER = re.compile(r"(\d+)\D*$")


@dataclass(frozen=True)
class FrameTimes:
    """The meaning of times."""

    stamps: dict[float, float] = field(default_factory=dict)  # numbers of frames, or seconds, by the time in the file
    in_seconds: bool = False
    notes: tuple[str, ...] = ()


def frame_times(file: Path, cameras: Sequence[Sequence[Frame]]) -> FrameTimes:
    """Return the meaning of the times of all cameras' frames; every frame has one.

    Raises:
        InputError: steps from frame to frame are those of no rate in any unit; names the file.
    """
    moments = sorted({frame.time for frames in cameras for frame in frames if frame.time is not None})
    if len(moments) < 2:
        return FrameTimes(dict.fromkeys(moments, 0.0))
    if moments[0] >= 0 and moments[-1] <= 1:
        step = float(np.diff(moments).min())
        return FrameTimes({moment: float(round((moment - moments[0]) / step)) for moment in moments})
    steps = np.concatenate([_steps(frames) for frames in cameras])
    step = float(np.median(steps if len(steps) else np.diff(moments)))
    whole = all(float(moment).is_integer() for moment in moments)
    if whole and (step <= _LARGEST_STEP_OF_FRAMES or _are_numbers_of_pictures(cameras)):
        return FrameTimes({moment: moment for moment in moments})
    unit = unit_of_step(step, None)
    if unit is None:
        problem = (
            f"times of frames are {step:.6g} apart, which is no usual rate in seconds, milli-, micro- or nanoseconds"
        )
        raise InputError(file, problem, 'write times in seconds, or remove "time" from all frames to count them')
    stamps = {moment: (moment - moments[0]) / unit.per_second for moment in moments}
    if unit is SECONDS:
        return FrameTimes({moment: moment for moment in moments}, in_seconds=True)
    rate = unit.per_second / step
    note = f"the times of {file.name} are taken for {unit.name}: {rate:.4g} frames per second"
    return FrameTimes(stamps, True, (note,))


def _steps(frames: Sequence[Frame]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    steps: np.ndarray[tuple[int], np.dtype[np.float64]] = np.diff(sorted({frame.time or 0.0 for frame in frames}))
    return steps


def _are_numbers_of_pictures(cameras: Sequence[Sequence[Frame]]) -> bool:
    """Whether the last numbers in the pictures' names step as their times do."""
    for frames in cameras:
        found = [(_LAST_NUMBER.search(frame.file.stem), frame.time or 0.0) for frame in frames]
        pairs = sorted((time, int(number[1][-15:])) for number, time in found if number)
        if len(pairs) < len(frames) or any(
            second[1] - first[1] != second[0] - first[0] for first, second in pairwise(pairs)
        ):
            return False
    return True
