"""The stages of a job by name, and how settings give each of them a number of seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

from hgs_core.base.errors import InputError

__all__ = ["STAGES", "StageSeconds"]

STAGES = ("initialise", "train", "encode", "publish")


@dataclass(frozen=True)
class StageSeconds:
    """Seconds, above 0, for every stage: `most` of them alike, and some with their own number.

    Written `300` or `300,train=60,encode=900`.
    """

    most: float
    own: tuple[tuple[str, float], ...] = ()

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        """Read what `str` gives.

        Raises:
            InputError: under the setting's `name`, if a number is not positive or a stage is unknown.
        """
        most, *rest = text.split(",")
        own: list[tuple[str, float]] = []
        for part in rest:
            stage, _, number = part.partition("=")
            if stage.strip() not in STAGES:
                raise InputError(name, f"{part!r} names no stage; they are {', '.join(STAGES)}", "write encode=900")
            own.append((stage.strip(), _seconds(name, number)))
        return cls(_seconds(name, most), tuple(own))

    def of(self, stage: str) -> float:
        """Return the seconds of a stage."""
        return dict(self.own).get(stage, self.most)

    def __str__(self) -> str:
        return ",".join([str(self.most), *(f"{stage}={seconds}" for stage, seconds in self.own)])


def _seconds(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        raise InputError(name, f"{text!r} is not a positive number of seconds")
    return value
