"""Dead spans of cameras: frozen, blank or repeated pictures while the other cameras see motion.

The offset of such a camera means nothing. A camera counts as frozen only where the others' pictures change, and as
blank only where theirs are not: a pause of the scene and lights that go out concern all cameras. Most others are to
change, or one where a camera shows the same picture, without noise, half of the time: most cameras may have frozen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np
import numpy.typing as npt

from hgs_core.base.cores import core_pool
from hgs_core.check.picture_changes import Picture, PictureChanges, picture_changes, same_picture

__all__ = ["DeadSpan", "Death", "WatchedCamera", "watch_cameras"]

_BLANK_SPREAD = 1.5  # levels
_STILL = 0.15  # mean change, as a share of the usual one
_STILL_ENERGY = 0.02  # motion energy, as a share of the usual one
_WITHOUT_NOISE = 0.05  # mean change, levels
_ALIVE_PERCENTILE = 85
_LEAST_USUAL = 0.3  # share of the other cameras' value
_FLOOR = 0.3  # levels of noise
_ABRUPT = 0.5  # motion energy, as a share of the usual one
_LONG = 3  # changes
_MOST_FREEZES = 3  # more are repeated pictures
_SPARSE = 2  # changes between frames far apart
_FEWEST_REPEATS = 4
_UNSURE_SHARE = 0.15  # share of the frames below which a doubtful freeze is not reported

Bools = npt.NDArray[np.bool_]
Floats = npt.NDArray[np.float64]


class Death(Enum):
    """Kinds of dead spans."""

    FROZEN = "frozen"
    BLANK = "blank"
    REPEATS = "repeats"


@dataclass(frozen=True)
class DeadSpan:
    """Frames `first` to `last` of a camera, of a capture of `count`."""

    death: Death
    first: int
    last: int
    count: int
    certain: bool  # whether a person or object that left the view is ruled out
    level: float = 0.0  # grey level of blank pictures, 0..255
    repeats: int = 0  # repeated pictures

    @property
    def dead(self) -> int:
        """How many frames are dead."""
        return self.repeats if self.death is Death.REPEATS else self.last - self.first + 1


@dataclass(frozen=True)
class WatchedCamera:
    """Changes between the watched pictures of a camera, and its dead spans."""

    changes: PictureChanges
    dead: tuple[DeadSpan, ...]

    @property
    def mostly_dead(self) -> bool:
        """Whether less than half of the frames are alive."""
        return bool(self.dead) and 2 * sum(span.dead for span in self.dead) > self.dead[0].count

    def energy(self) -> Floats | None:
        """Return the motion energy between the first, consecutive frames, NaN in dead spans; None if mostly dead."""
        if self.mostly_dead:
            return None
        leading = np.cumprod(np.diff(self.changes.frames) == 1).astype(bool)
        energy: Floats = self.changes.energy[leading].copy()
        for span in (span for span in self.dead if span.death is not Death.REPEATS):
            energy[max(0, span.first - 1) : span.last + 1] = np.nan
        return energy


def watch_cameras(
    pictures: Sequence[Picture],  # one for each camera
    frames: npt.NDArray[np.int64],  # watched, increasing, from 0 to the last
    measured: Callable[[int], None] = lambda cameras: None,
) -> list[WatchedCamera]:
    """Measure the pictures of all cameras, which show the same moments, and find dead spans; `measured` counts cameras.

    Raises:
        InputError: a picture is missing or unreadable.
    """
    changes = []
    with core_pool() as pool:
        for number, one in enumerate(pool.map(partial(picture_changes, frames=frames), pictures), 1):
            changes.append(one)
            measured(number)
    blank = np.stack([one.spread < _BLANK_SPREAD for one in changes])
    blank &= _in_most_others(~blank)
    usual = _usual([one.energy for one in changes])
    usual_mean = _usual([one.mean for one in changes])
    energy, mean = np.stack([one.energy for one in changes]), np.stack([one.mean for one in changes])
    moving = (energy > _STILL_ENERGY * usual[:, None]) & (energy > 0)
    others_move = _in_most_others(moving, among=np.asarray(moving.any(axis=1), bool))
    still = ~moving & (mean <= _STILL * usual_mean[:, None]) & ~(blank[:, 1:] & blank[:, :-1])
    alone = still & (mean <= _WITHOUT_NOISE) & moving.any(axis=0)
    others_move |= alone & (2 * alone.sum(axis=1) >= alone.shape[1])[:, None]
    watched = []
    for index, (one, picture) in enumerate(zip(changes, pictures, strict=True)):
        spans = _blank_spans(one, blank[index], picture)
        spans += _still_spans(one, still[index], others_move[index], float(usual[index]), picture)
        watched.append(WatchedCamera(one, tuple(sorted(spans, key=lambda span: span.first))))
    return watched


def _in_most_others(true: Bools, among: Bools | None = None) -> Bools:
    """Return for each camera [C, N] whether at least half of the others are true; `among` [C] leaves cameras out."""
    counted = np.ones(len(true), bool) if among is None else among
    own = true & counted[:, None]
    others = (int(counted.sum()) - counted.astype(int))[:, None]
    return np.asarray((others > 0) & (2 * (own.sum(axis=0) - own) >= others), bool)


def _blank_spans(one: PictureChanges, blank: Bools, picture: Picture) -> list[DeadSpan]:
    def is_blank(frame: int) -> bool:
        return float(picture_changes(picture, [frame]).spread[0]) < _BLANK_SPREAD

    spans = []
    for start, end in _runs(blank):
        first, last = _refined(one, start, end, is_blank)
        level = float(one.level[start : end + 1].mean())
        spans.append(DeadSpan(Death.BLANK, first, last, one.count, certain=True, level=level))
    return spans


def _usual(of_cameras: Sequence[Floats]) -> Floats:
    """Return how much changes where something moves, for each camera [C]: of one that hardly moves by the others."""
    if len(of_cameras[0]) == 0:
        return np.zeros(len(of_cameras))
    own = np.array([np.percentile(one, _ALIVE_PERCENTILE) for one in of_cameras])
    return np.asarray(np.maximum(own, _LEAST_USUAL * np.median(own)), np.float64)


def _still_spans(
    one: PictureChanges, still: Bools, others_move: Bools, usual: float, picture: Picture
) -> list[DeadSpan]:
    """Return frozen spans, or the repeated pictures; `still` [N - 1] are changes that the camera does not show."""
    floor = one.floor[one.energy >= _ABRUPT * usual]
    noisy = len(floor) > 0 and float(np.median(floor)) > _FLOOR
    runs = []
    for start, end in _joined(_runs(still), one.energy, usual):
        missed = start + np.flatnonzero(still[start : end + 1] & others_move[start : end + 1])
        if len(missed) >= (_LONG if np.diff(one.frames)[start : end + 1].max() == 1 else _SPARSE):
            runs.append((int(missed[0]), int(missed[-1])))
    if len(runs) > _MOST_FREEZES:
        runs = []
    rest, spans = still & others_move, []
    for start, end in runs:
        rest[start : end + 1] = False
        beside = [i for i in (start - 2, start - 1, end + 1, end + 2) if 0 <= i < len(one.energy)]
        abrupt = any(one.energy[i] >= _ABRUPT * usual and one.inside[i] for i in beside)
        frozen = partial(same_picture, picture, int(one.frames[start + 1]))
        first, last = _refined(one, start, end + 1, frozen)
        span = DeadSpan(Death.FROZEN, first, last, one.count, certain=bool(beside) and (noisy or abrupt))
        if span.certain or span.dead >= _UNSURE_SHARE * span.count:
            spans.append(span)
    repeats = [i for i in np.flatnonzero(rest) if (one.energy[max(0, i - 3) : i + 4] >= _ABRUPT * usual).any()]
    if len(repeats) >= _FEWEST_REPEATS:
        first, last = int(one.frames[repeats[0]]), int(one.frames[repeats[-1] + 1])
        spans.append(DeadSpan(Death.REPEATS, first, last, one.count, certain=True, repeats=len(repeats)))
    return spans


def _runs(true: Bools) -> list[tuple[int, int]]:
    """Return the first and last index of every run of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], true, [False])).astype(int)))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def _joined(runs: list[tuple[int, int]], energy: Floats, usual: float) -> list[tuple[int, int]]:
    """Return the runs, joined over single small changes: a keyframe of a frozen video differs a little."""
    joined: list[tuple[int, int]] = []
    for start, end in runs:
        if (
            joined
            and start - joined[-1][1] == 2
            and (energy[start - 1] < _ABRUPT * usual or len(runs) <= _MOST_FREEZES)
        ):
            joined[-1] = (joined[-1][0], end)
        else:
            joined.append((start, end))
    return joined


def _refined(one: PictureChanges, start: int, end: int, dead: Callable[[int], bool]) -> tuple[int, int]:
    """Return the first and last dead frame around the watched ones `start` to `end`, by bisection between those."""
    first, last = int(one.frames[start]), int(one.frames[end])
    if start > 0:
        before = int(one.frames[start - 1])
        while first - before > 1:
            middle = (before + first) // 2
            before, first = (before, middle) if dead(middle) else (middle, first)
    if end + 1 < len(one.frames):
        after = int(one.frames[end + 1])
        while after - last > 1:
            middle = (after + last) // 2
            after, last = (after, middle) if dead(middle) else (middle, last)
    return first, last
