"""The numbers in the names of pictures: those digits that change within a folder, as counts or as time stamps."""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

__all__ = ["Numbers", "labels_of", "numbers_in"]

Numbers = tuple[tuple[int, ...], ...]
"""Of each camera's pictures."""

_DIGITS = re.compile(r"\d+")
_DECIMAL = re.compile(r"(?<![\d.])(\d+)\.(\d+)\D*$")
_DATE = r"(?<!\d)((?:19|20)\d\d)[-_.]?(\d\d)[-_.]?(\d\d)[-_.Tt ]{0,3}"
_TIME = r"([01]\d|2[0-3])[-_.:h]?([0-5]\d)[-_.:m]?([0-5]\d)"
_FRACTION = r"(\d{3,9})\D*$"
_OF_DATE = re.compile(rf"{_DATE}{_TIME}[-_.,:s]?{_FRACTION}")
_OF_SECOND = re.compile(rf"(?<!\d)()()(){_TIME}(\d{{3,9}}|)\D*$")
_OF_DAY = re.compile(rf"(?<!\d)()()(){_TIME}[-_.,:s]?{_FRACTION}")
_IN_ONE = re.compile(rf"{_DATE}{_TIME}{_FRACTION}")  # a number that counts may follow a date and a time
_SINCE_1970 = {13: 1e-3, 16: 1e-6, 19: 1e-9}  # seconds of one, by the digits of a number that begins with 1


def labels_of(files: Sequence[Path]) -> list[str]:
    """Return the distinguishing names of a camera's pictures: without endings, or those of their folders."""
    parts = [(*file.parts[:-1], file.stem) for file in files]
    if len({len(one) for one in parts}) > 1:
        return [file.stem for file in files]
    changing = [place for place in range(len(parts[0])) if len({one[place] for one in parts}) > 1]
    return ["/".join(one[place] for place in changing or (-1,)) for one in parts]


def numbers_in(labels: Sequence[Sequence[str]]) -> tuple[Numbers, float | None] | None:
    """Return the numbers in names and, of time stamps, the seconds of one; None where no number tells moments."""
    if any(len({_DIGITS.sub("#", label.casefold()) for label in own}) > 1 for own in labels):
        return None
    groups = [[_DIGITS.findall(label)[::-1] for label in own] for own in labels]  # the last of a name first
    changing = [[p for p in range(len(own[0])) if len({int(one[p]) for one in own}) > 1] for own in groups]
    places = sorted({place for own in changing for place in own} or {0})
    several = max(map(len, changing)) > 1
    if (dated := _matched(labels, _OF_DATE if several else _IN_ONE, _of_day)) is not None:
        return dated
    decimal = _matched(labels, _DECIMAL, _decimal) if several and places == [0, 1] else None
    of_day = _matched(labels, _OF_DAY if several else _OF_SECOND, _of_day)
    if decimal is not None and (of_day is None or _spread(decimal[0]) <= _spread(of_day[0])):
        return decimal
    if several:
        counted = [[place] * len(groups) for place in places]
    else:  # each camera may have its number at another place
        counted = [
            [own[0] if own else _place_of_one(one, groups, changing) for own, one in zip(changing, groups, strict=True)]
        ]
    columns = []
    for column in counted:
        if all(place < len(own[0]) for place, own in zip(column, groups, strict=True)):
            numbers = (tuple(int(one[place]) for one in own) for place, own in zip(column, groups, strict=True))
            columns.append(tuple(numbers))
    if len(counted) > 1:  # numbers that occur once tell pictures apart
        columns = [column for column in columns if all(len(set(own)) == len(own) for own in column)]
    stamps = [column for column in columns if _since_1970(column) is not None]
    if of_day is not None and not stamps and (several or _spread(of_day[0]) < _spread(columns[0])):
        return of_day  # 145959967 precedes 150000000
    best = next(iter(stamps or columns), None)
    return None if best is None else (best, _since_1970(best))


def _place_of_one(names: list[list[str]], groups: list[list[list[str]]], changing: list[list[int]]) -> int:
    """Return where the number of a camera's only picture is: where others with as many numbers have it."""
    alike = {own[0] for own, other in zip(changing, groups, strict=True) if own and len(other[0]) == len(names[0])}
    return alike.pop() if len(alike) == 1 else 0 if len(names[0]) == 1 else len(names[0])


def _matched(
    labels: Sequence[Sequence[str]], pattern: re.Pattern[str], value: Callable[[re.Match[str]], tuple[int, str] | None]
) -> tuple[Numbers, float | None] | None:
    """Return names of one pattern as whole numbers of their finest digit, of a whole part and a fraction of it."""
    found = [[pattern.search(label) for label in own] for own in labels]
    parts = [[part for match in own if match and (part := value(match)) is not None] for own in found]
    if any(len(own) < len(all_of_them) for own, all_of_them in zip(parts, labels, strict=True)):
        return None
    width = max(len(fraction) for own in parts for _, fraction in own)
    scale = 10**width
    whole = tuple(tuple(one for one, _ in own) for own in parts)
    numbers = tuple(tuple(one * scale + int(fraction.ljust(width, "0") or 0) for one, fraction in own) for own in parts)
    return numbers, (_since_1970(whole) or 1.0) / scale


def _decimal(match: re.Match[str]) -> tuple[int, str]:
    return int(match[1]), match[2]


def _of_day(match: re.Match[str]) -> tuple[int, str] | None:
    """Return the second and its fraction, since midnight or since the year 1; None: there is no such day."""
    year, month, day, hour, minute, second, fraction = match.groups()
    try:
        days = datetime.date(int(year), int(month), int(day)).toordinal() if year else 0
    except ValueError:
        return None
    return ((days * 24 + int(hour)) * 60 + int(minute)) * 60 + int(second), fraction


def _spread(numbers: Numbers) -> float:
    """Return by how much the largest step exceeds the usual one; infinite where numbers do not go on."""
    steps = sorted(b - a for own in numbers for a, b in pairwise(own))
    return steps[-1] / steps[(len(steps) - 1) // 2] if steps and steps[0] > 0 else float("inf")


def _since_1970(numbers: Numbers) -> float | None:
    digits = {len(str(number)) for own in numbers for number in own}
    if len(digits) > 1 or any(str(own[0])[0] != "1" for own in numbers):
        return None
    return _SINCE_1970.get(digits.pop())
