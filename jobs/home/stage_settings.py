"""The stages of a job by name, and how settings give each of them a number of seconds, bytes or things."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

from hgs_core.base.errors import InputError
from jobs.home.byte_sizes import bytes_of

__all__ = ["HELP", "SHOW", "STAGES", "StageBytes", "StageCount", "StageSeconds"]

STAGES = ("initialise", "train", "encode", "publish")
HELP = "help"  # make a segment of another worker's job
SHOW = "show"  # publish the finished segments of a training


@dataclass(frozen=True)
class _StageNumbers(ABC):
    most: float
    own: tuple[tuple[str, float], ...] = ()

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        """Read the form that `str` gives.

        Raises:
            InputError: under the setting's `name`, if a number is not positive or a stage is unknown.
        """
        most, *rest = text.split(",")
        own: list[tuple[str, float]] = []
        for part in rest:
            stage, _, number = part.partition("=")
            if stage.strip() not in STAGES:
                raise InputError(name, f"{part!r} names no stage; they are {', '.join(STAGES)}", "write encode=900")
            own.append((stage.strip(), cls._number(name, number)))
        return cls(cls._number(name, most), tuple(own))

    def of(self, stage: str) -> float:
        """Return the number of a stage."""
        return dict(self.own).get(stage, self.most)

    def __str__(self) -> str:
        return ",".join([str(self.most), *(f"{stage}={number}" for stage, number in self.own)])

    @staticmethod
    @abstractmethod
    def _number(name: str, text: str) -> float:
        """Return a number above 0, or raise an InputError under the setting's `name`."""


class StageSeconds(_StageNumbers):
    """Seconds, above 0, for every stage: `most` of them alike, and some with their own number.

    Written `300` or `300,train=60,encode=900`.
    """

    @staticmethod
    def _number(name: str, text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not 0 < value < math.inf:
            raise InputError(name, f"{text!r} is not a positive number of seconds")
        return value


class StageBytes(_StageNumbers):
    """The same for bytes: `8G` or `8G,train=24G`."""

    @staticmethod
    def _number(name: str, text: str) -> float:
        value = bytes_of(text, name)
        if value <= 0:
            raise InputError(name, f"{text!r} is not a positive number of bytes")
        return value


class StageCount(_StageNumbers):
    """The same for whole numbers: `256` or `256,train=1024`."""

    @staticmethod
    def _number(name: str, text: str) -> float:
        if not text.strip().isdecimal() or int(text) < 1:
            raise InputError(name, f"{text!r} is not a positive whole number", "write one such as 256")
        return int(text)
