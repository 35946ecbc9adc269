"""SMPTE time codes of cameras: 14:30:49:10, or 14:30:49;10 where codes drop frames to keep up with the clock."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

__all__ = ["CodedStart", "CodedStarts", "starts_by_timecode", "timecode_seconds"]

_TIMECODE = re.compile(r"(\d{1,2}):([0-5]\d):([0-5]\d)([:;.,])(\d{2,3})")
_UNSET = ("00:00:00:00", "01:00:00:00")  # first codes of recorders with unset clocks
_DAY = 86400.0  # seconds
_SAME = 1e-6  # seconds


@dataclass(frozen=True)
class CodedStart:
    """The time code of a camera's first frame."""

    name: str
    code: str
    rate: float  # frames per second
    length: float  # seconds that the camera recorded


@dataclass(frozen=True)
class CodedStarts:
    """When cameras began by their time codes."""

    seconds: tuple[float, ...]  # one for each camera, on one clock; none: no usable codes
    notes: tuple[str, ...] = ()  # notes for people
    problem: str = ""  # why the codes cannot all be right, with the cameras that are apart from most


def timecode_seconds(code: str, rate: float, dropping: bool | None = None) -> float | None:
    """Return the seconds of a SMPTE time code; None if it is none.

    Codes drop frames where a semicolon, a comma or a full stop says so, or where `dropping` does; only those of 30 or
    60 frames a second can.
    """
    parts = _TIMECODE.fullmatch(code.strip())
    if parts is None:
        return None
    hours, minutes, seconds, frame = int(parts[1]), int(parts[2]), int(parts[3]), int(parts[5])
    nominal = max(1, round(rate))
    total = ((hours * 60 + minutes) * 60 + seconds) * nominal + frame
    if (_drops(code) if dropping is None else dropping) and nominal % 30 == 0:
        # Two numbers a minute (four at 60) are skipped, but not every tenth minute.
        whole = hours * 60 + minutes
        total -= nominal // 15 * (whole - whole // 10)
    exact = Fraction(nominal * 1000, 1001) if abs(rate - nominal / 1.001) < abs(rate - nominal) else Fraction(nominal)
    return float(total / exact)


def starts_by_timecode(cameras: Sequence[CodedStart]) -> CodedStarts:
    """Return when cameras began; nothing where a code is none, or all are alike.

    Where some codes drop frames and some do not, and cameras would have no moment in common, all are read as dropping
    them: recorders write the colon where they mean the semicolon.
    """
    starts = [timecode_seconds(one.code, one.rate) for one in cameras]
    known = [start for start in starts if start is not None]
    if len(known) < len(cameras) or max(known) - min(known) <= _SAME:
        return CodedStarts(())
    if _overlap(known, cameras):
        return CodedStarts(tuple(known))
    over = [start + _DAY * (start < _DAY / 2) for start in known]
    if max(known) - min(known) > _DAY / 2 and _overlap(over, cameras):
        return CodedStarts(tuple(over), ("the time codes go over midnight",))
    dropping = [_drops(one.code) for one in cameras]
    if any(dropping) and not all(dropping):
        alike = [timecode_seconds(one.code, one.rate, dropping=True) or 0.0 for one in cameras]
        if _overlap(alike, cameras):
            odd = ", ".join(one.name for one, drops in zip(cameras, dropping, strict=True) if not drops)
            note = f"the time codes of {odd} have a colon, others a semicolon: all are read as dropping frames"
            return CodedStarts(tuple(alike), (note,))
    return CodedStarts(tuple(known), problem=_apart(known, cameras))


def _drops(code: str) -> bool:
    parts = _TIMECODE.fullmatch(code.strip())
    return parts is not None and parts[4] != ":"


def _overlap(starts: Sequence[float], cameras: Sequence[CodedStart]) -> bool:
    ends = [start + one.length for start, one in zip(starts, cameras, strict=True)]
    return max(starts) <= min(ends)


def _apart(starts: Sequence[float], cameras: Sequence[CodedStart]) -> str:
    """Return the sentence that names the cameras which no moment joins with most others."""
    spans = [(start, start + one.length) for start, one in zip(starts, cameras, strict=True)]
    joined = [sum(a <= end and start <= b for a, b in spans) for start, end in spans]
    middle = float(np.median([start for (start, _), count in zip(spans, joined, strict=True) if count == max(joined)]))
    odd = []
    for one, start, count in zip(cameras, starts, joined, strict=True):
        if count < max(joined):
            unset = ", as of a recorder whose clock was never set" if one.code.replace(";", ":") in _UNSET else ""
            way = "after" if start > middle else "before"
            odd.append(f"{one.name} ({one.code}, {abs(start - middle):.2f} s {way} most{unset})")
    usual = next(one.code for one, count in zip(cameras, joined, strict=True) if count == max(joined))
    if not odd:
        codes = ", ".join(f"{one.name} {one.code}" for one in cameras[:8])
        return f"by their time codes the cameras have no moment in common: {codes}"
    return (
        f"by their time codes these have no moment in common with most, which begin near {usual}: {', '.join(odd[:8])}"
    )
