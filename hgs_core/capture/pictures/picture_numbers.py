"""The moments of pictures in a folder, from their names: frame numbers or time stamps.

Pictures of equal numbers were taken together, whatever else there is in the folders: a number that a camera lacks is a
moment of which it has no picture. Numbers are those digits of a name that change within a folder. They count frames, by
ones or by any other step that all share, or they are time stamps: of 13, 16 or 19 digits (milli-, micro- or nanoseconds
since 1970), with a decimal point (seconds), as hours, minutes and seconds, or such that go on by nearly equal steps.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.picture_names import Numbers, labels_of, numbers_in

__all__ = ["PictureNumbers", "picture_numbers"]

_EVEN = 0.1  # share of the usual step; steps of time stamps differ by less
_COARSE = 10  # times the step that all numbers share, from which on uneven steps are time stamps
_FEWEST_STEPS = 5  # steps that identify time stamps
_LONGEST = 10**9  # frames, a year at 30 a second
_SHORTEST_STEP = 1 / 960  # seconds; the fastest cameras of phones
_DAY = 86400  # seconds
_FEWEST_COUNTED = 1000  # numbers of a counter that begins anew
_MOST_CAMERAS = 12  # cameras listed in a message
_MOST_NAMED = 6  # gaps that a note names


@dataclass(frozen=True)
class PictureNumbers:
    """The numbers of some cameras' pictures."""

    cameras: tuple[str, ...]
    numbers: tuple[tuple[int, ...], ...]  # increasing, one row for each camera
    unit: float | None = None  # seconds of one; None: they count frames
    step: int = 1  # difference between neighbours
    told: bool = True  # whether names have them; else pictures were counted

    def seconds(self, rate: float) -> list[npt.NDArray[np.float64]]:
        """Return when each camera's pictures were taken, seconds; `rate` is frames per second where frames count."""
        first = min(own[0] for own in self.numbers)
        if self.unit is None:
            return [np.array([(n - first) // self.step for n in own], np.float64) / rate for own in self.numbers]
        return [np.array([n - first for n in own], np.float64) * self.unit for own in self.numbers]

    def rate(self, assumed: float) -> float:
        """Return the pictures per second that time stamps tell; `assumed` where there are none."""
        if self.unit is None:
            return assumed
        steps = [b - a for own in self.numbers for a, b in pairwise(own)]
        usual = float(np.median(steps))
        periods = sum(max(1, round(step / usual)) for step in steps)
        return periods / (sum(steps) * self.unit)

    def notes(self) -> list[str]:
        """Say which pictures are missing between others, and whether numbers are taken for time stamps."""
        if self.unit is not None:
            word = {1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds"}.get(self.unit, "seconds")
            return [f"the pictures' names are taken for time stamps in {word}: {self.rate(0):.4g} pictures a second"]
        gaps = {name: _gaps(own, self.step) for name, own in zip(self.cameras, self.numbers, strict=True)}
        everybody = set.intersection(*(set(one) for one in gaps.values()))
        said = [f"no camera has {_pictures(sorted(everybody), self.step)}"] if everybody else []
        for name, one in gaps.items():
            if own := sorted(set(one) - everybody):
                said.append(f"{name} has no {_pictures(own, self.step)}")
        return said

    def contradictions(self, file: str, stamps: Sequence[Sequence[float]]) -> list[str]:
        """Say where a file that gives pictures times, in any unit, contradicts their numbers."""
        steps = [
            (name, a, b, later - sooner)
            for name, own, times in zip(self.cameras, self.numbers, stamps, strict=True)
            for (a, sooner), (b, later) in pairwise(zip(own, times, strict=True))
        ]
        if not steps or not self.told:
            return []
        usual = float(np.median([time / (b - a) for _, a, b, time in steps]))
        if usual <= 0:
            return []  # the clock refuses times that do not go on
        odd = [step for step in steps if abs(step[3] / usual - (step[2] - step[1])) > 0.5 * self.step]
        if not odd:
            return []
        name, a, b, time = odd[0]
        more = f", and {len(odd) - 1} more like this" if len(odd) > 1 else ""
        told = f"of {name} comes {b}, as if {time / usual / self.step:.3g} later: {file} counts, not the numbers"
        return [f"after picture {a} {told}{more}"]

    def require_shared(self, where: object) -> None:
        """Refuse numbers that do not tell which pictures were taken together.

        Raises:
            InputError: fewer than two are there for all cameras that have as many; or all cameras have equally many
                without a gap, and count from different numbers. Names the cameras and the numbers they have.
        """
        if self.unit is not None or max(map(len, self.numbers)) < 2:
            return
        spans = [f"{name} {_span(own, self.step)}" for name, own in zip(self.cameras, self.numbers, strict=True)]
        listed = ", ".join(spans[:_MOST_CAMERAS]) + (", ..." if len(spans) > _MOST_CAMERAS else "")
        together = f"if their first pictures were taken together, write {_frames({self.cameras[-1]: 0})} to sync.json"
        shared = set.intersection(*map(set, self.numbers))
        if len(shared) < 2:
            only = f"only number {min(shared)} is" if shared else "none is"
            problem = f"by the numbers of their pictures {only} there for all cameras: {listed}"
            raise InputError(where, problem, together)
        first = min(own[0] for own in self.numbers)
        late = {n: (own[0] - first) // self.step for n, own in zip(self.cameras, self.numbers, strict=True)}
        late = {name: frames for name, frames in late.items() if frames}
        in_a_row = not any(_gaps(own, self.step) for own in self.numbers)
        if late and in_a_row and len({len(own) for own in self.numbers}) == 1:
            count = len(self.numbers[0])
            problem = f"all cameras have {count} pictures in a row, by numbers that differ: {listed}"
            raise InputError(where, problem, f"{together}; if those of equal numbers were, {_frames(late)}")


def picture_numbers(
    where: object, cameras: Sequence[str], files: Sequence[Sequence[Path]], *, in_order: bool = False
) -> PictureNumbers:
    """Return the numbers of each camera's pictures, in the order of file names.

    Where names have no number that tells, pictures of equal names are of one moment, in that order. With `in_order`,
    where something else tells when they were taken, any names will do.

    Raises:
        InputError: two pictures of a camera have one number, or names tell no moment and are not alike in all cameras.
    """
    in_a_row = PictureNumbers(tuple(cameras), tuple(tuple(range(len(own))) for own in files), told=False)
    if max(map(len, files)) < 2:
        return in_a_row
    labels = [labels_of(own) for own in files]
    read = numbers_in(labels)
    if read is None:
        if not in_order:
            _by_label(where, cameras, labels)
        return in_a_row
    numbers, unit = read
    for name, own, paths in zip(cameras, numbers, files, strict=True):
        for (a, earlier), (b, later) in pairwise(zip(own, paths, strict=True)):
            if a == b and not in_order:
                problem = f"{earlier.name} and {later.name} are both picture {a} of camera {name}"
                raise InputError(later, problem, "take one of them away")
    if any(a >= b for own in numbers for a, b in pairwise(own)):
        return in_a_row
    for name, own, paths in zip(cameras, numbers, files, strict=True):
        _require_one_turn(name, own, paths, unit)
    origin = numbers[0][0]
    step = math.gcd(*(number - origin for own in numbers for number in own)) or 1
    unit = unit or _uneven(numbers, step)
    if unit is not None and (fastest := _usual(numbers) * unit) < _SHORTEST_STEP:
        problem = f"by the time stamps in their names, pictures follow one another every {fastest * 1e3:.3g} ms"
        counted = "where the last number counts the pictures of a second, call them by the numbers of their frames"
        raise InputError(where, problem, f"{counted}, such as 0007.png")
    first, last = min(own[0] for own in numbers), max(own[-1] for own in numbers)
    if unit is None and (last - first) // step > _LONGEST:
        problem = f"the numbers of its pictures go from {first} to {last}, too far for frames"
        raise InputError(where, problem, "call each picture by the number of its frame, such as 0007.png")
    return PictureNumbers(tuple(cameras), numbers, unit, step)


def _usual(numbers: Numbers) -> float:
    """Return the usual difference between neighbours."""
    return float(np.median([b - a for own in numbers for a, b in pairwise(own)]))


def _uneven(numbers: Numbers, step: int) -> float | None:
    """Return the seconds of one if numbers go on like time stamps: by steps that are nearly equal, and not equal."""
    steps = [b - a for own in numbers for a, b in pairwise(own)]
    usual = _usual(numbers)
    if len(steps) < _FEWEST_STEPS or usual < _COARSE * step:
        return None
    if any(abs(one / usual - round(one / usual)) > _EVEN for one in steps):
        return None
    return 1e-3 if usual < 1e3 else 1e-6 if usual < 1e6 else 1e-9


def _require_one_turn(camera: str, numbers: Sequence[int], files: Sequence[Path], unit: float | None) -> None:
    """Refuse counters that begin anew, and times of a day that go over midnight: names have another order then.

    Raises:
        InputError: the pictures before the largest gap were taken last.
    """
    gap, last = max((b - a, place) for place, (a, b) in enumerate(pairwise(numbers))) if len(numbers) > 1 else (0, 0)
    turn = round(_DAY / unit) if unit is not None else 10 ** len(str(numbers[-1]))
    late = f"{files[0].name} to {files[last].name}" if last else files[0].name
    if unit is not None and numbers[-1] < turn < 2 * gap:
        problem = f"its pictures go over midnight, and by their names {late} come first"
        dated = " and ".join(
            f"{day}_{file.name}" for day, file in (("2026-01-02", files[0]), ("2026-01-01", files[-1]))
        )
        raise InputError(files[0].parent, problem, f"put dates before the names of all, as in {dated}")
    if unit is None and turn >= _FEWEST_COUNTED and numbers[0] < 2 and numbers[-1] == turn - 1 and 2 * gap > turn:
        problem = f"the counter of {camera} begins anew after {files[-1].name}, and by their names {late} come first"
        raise InputError(files[0].parent, problem, f"add {turn - numbers[0]} to their numbers")


def _by_label(where: object, cameras: Sequence[str], labels: Sequence[Sequence[str]]) -> None:
    """Require that pictures are called alike in all cameras.

    Raises:
        InputError: a camera has a picture that another one has not, or two that are called alike.
    """
    cure = "call each picture by the number of its frame, such as 0007.png, the same in all cameras"
    bare = [
        [text.casefold().replace(name.casefold(), "") for text in own]
        for name, own in zip(cameras, labels, strict=True)
    ]
    for name, own in zip(cameras, bare, strict=True):
        if len(set(own)) < len(own):
            twice = next(text for place, text in enumerate(own) if text in own[:place])
            raise InputError(where, f"camera {name} has two pictures called {twice}", "take one of them away")
        for other, theirs in zip(cameras, bare, strict=True):
            if missing := next((text for text in theirs if text not in own), None):
                problem = (
                    f"camera {name} has no picture called {missing}, as {other} has, and their names have no number"
                )
                raise InputError(where, f"{problem} that says which were taken together", cure)


def _gaps(numbers: Sequence[int], step: int) -> list[tuple[int, int]]:
    return [(a + step, b - step) for a, b in pairwise(numbers) if b - a > step]


def _pictures(gaps: Sequence[tuple[int, int]], step: int) -> str:
    named = [str(a) if a == b else f"{a} to {b}" if b - a > step else f"{a}, {b}" for a, b in gaps[:_MOST_NAMED]]
    more = f" and {len(gaps) - _MOST_NAMED} gaps more" if len(gaps) > _MOST_NAMED else ""
    return f"picture {', '.join(named)}{more}"


def _span(numbers: Sequence[int], step: int) -> str:
    return str(numbers[0]) if len(numbers) == 1 else f"{numbers[0]} to {numbers[-1]}" + (f" by {step}" * (step > 1))


def _frames(starts: dict[str, int]) -> str:
    return json.dumps({"frames": starts})
