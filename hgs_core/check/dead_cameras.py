"""Findings about cameras that were frozen, blank or repeated pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hgs_core.base.errors import InputError
from hgs_core.check.findings import Finding
from hgs_core.check.watched_cameras import DeadSpan, Death, WatchedCamera

__all__ = ["judge_dead", "require_alive"]

_FROZEN_STOPS = 0.25  # share of the frames
_BLANK_STOPS = 0.1  # share of the frames


def judge_dead(names: Sequence[str], cameras: Sequence[WatchedCamera]) -> list[Finding]:
    """Report the dead spans of every camera."""
    return [
        Finding(_stops(span), (name,), _problem(span), _cure(name), of_pictures=True)
        for name, camera in zip(names, cameras, strict=True)
        for span in camera.dead
    ]


def require_alive(where: Path, names: Sequence[str], cameras: Sequence[WatchedCamera]) -> None:
    """Refuse to measure when cameras began where one of them was mostly dead.

    Raises:
        InputError: names the first of them and its span.
    """
    for name, camera in zip(names, cameras, strict=True):
        if camera.mostly_dead:
            cure = "take its files and its pose out of the capture: when it began cannot be measured"
            raise InputError(where, f"{name}: {_problem(camera.dead[0])}", cure)


def _stops(span: DeadSpan) -> bool:
    least = {Death.BLANK: _BLANK_STOPS, Death.FROZEN: _FROZEN_STOPS, Death.REPEATS: 1.0}[span.death]
    return span.certain and span.dead >= least * span.count


def _problem(span: DeadSpan) -> str:
    if span.death is Death.BLANK:
        return f"its pictures are {_colour(span.level)} {_where(span)}"
    if span.death is Death.FROZEN:
        return f"it shows the same picture {_where(span)}, while those of the other cameras change"
    repeated = f"{span.repeats} of its {span.count} frames repeat the one before, between {span.first} and {span.last}"
    return f"{repeated}: it was recorded at a lower rate, or frames were lost"


def _cure(name: str) -> str:
    return f"train without it (--hold-out {name}), or take its files and its pose out of the capture"


def _where(span: DeadSpan) -> str:
    if span.first == 0 and span.last == span.count - 1:
        return f"in all {span.count} frames"
    if span.last == span.count - 1:
        return f"from frame {span.first} on ({span.dead} of {span.count} frames)"
    if span.first == 0:
        return f"until frame {span.last} ({span.dead} of {span.count} frames)"
    return f"in frames {span.first} to {span.last}"


def _colour(level: float) -> str:
    if level < 24:
        return "black"
    return "white" if level > 231 else f"of one grey level ({level:.0f})"
