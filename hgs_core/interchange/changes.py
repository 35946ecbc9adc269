"""Counted losses and changes of a scene in a file format, as `hgs import` and `hgs export` report them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Action", "Change", "Written", "most_of_any", "nonzero"]


class Action(StrEnum):
    """The kinds of change."""

    LEFT_OUT = "left out"
    LIMITED = "limited"  # moved into the range of the format
    ROUNDED = "rounded"
    REPLACED = "replaced"  # the nearest value of the format instead
    ASSUMED = "assumed"  # not stated in the file


@dataclass(frozen=True)
class Change:
    """One kind of change, and how many splats it met.

    `what` is the attribute, "splats" for whole splats; `of` the splats that there were. Both counts are None for what a
    scene has as a whole.
    """

    action: Action
    what: str
    count: int | None
    of: int | None
    reason: str

    @staticmethod
    def whole(action: Action, what: str, reason: str) -> Change:
        """Return a change of a property of the whole scene."""
        return Change(action, what, None, None, reason)

    @staticmethod
    def where(action: Action, what: str, met: NDArray[np.bool_], reason: str) -> Change:
        """Return a change of the splats for which `met` holds: [N], or [N, ...] with any number of a splat."""
        return Change(action, what, int(met.any(axis=tuple(range(1, met.ndim))).sum()), len(met), reason)

    @staticmethod
    def rounded(what: str, before: NDArray[Any], after: NDArray[Any], reason: str) -> Change:
        """Return a rounding of the splats of which a number [N, ...] is another one `after`, beyond float32."""
        off = np.abs(np.asarray(after, np.float64) - before) > 1e-6 * np.maximum(1.0, np.abs(before))
        return Change.where(Action.ROUNDED, what, off, reason)

    def __str__(self) -> str:
        """Say it in one line."""
        if self.count is None or self.of is None:
            return f"{self.what} {self.action}: {self.reason}"
        splats = f"all {self.of:,} splats" if self.count == self.of else f"{self.count:,} of {self.of:,} splats"
        return f"{splats if self.what == 'splats' else f'{self.what} of {splats}'} {self.action}: {self.reason}"

    def to_json(self) -> dict[str, Any]:
        """Return the plain form: action, subject, count, total, reason."""
        return {
            "action": str(self.action),
            "what": self.what,
            "count": self.count,
            "of": self.of,
            "reason": self.reason,
        }


@dataclass(frozen=True)
class Written:
    """The bytes of a file, and the losses."""

    data: bytes
    changes: tuple[Change, ...]


def nonzero(changes: Iterable[Change]) -> tuple[Change, ...]:
    """Return the changes that met any splat, or the whole."""
    return tuple(change for change in changes if change.count != 0)


def most_of_any(changes: Iterable[Change]) -> tuple[Change, ...]:
    """Return, of the changes of several files, of each kind the one that met the most splats."""
    most: dict[tuple[Action, str, str], Change] = {}
    for change in changes:
        kind = (change.action, change.what, change.reason)
        if kind not in most or (change.count or 0) > (most[kind].count or 0):
            most[kind] = change
    return tuple(most.values())
