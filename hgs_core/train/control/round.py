"""The base of rounds of control: their schedule and their context."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from hgs_core.scene.camera import Camera
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.schedule import Schedule
from hgs_core.train.segment_cuts import CaptureSegment
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingViews

__all__ = ["Round", "RoundContext", "is_after_share", "is_one_of_ten"]

_FIRST_OF_TEN = 0.1  # share of the iterations that pass before them


@dataclass(frozen=True)
class RoundContext:
    """The context of a round besides the state that it changes."""

    iteration: int  # the iteration it follows, from 0
    seed: int  # seed of the run
    schedule: Schedule
    views: TrainingViews
    segment: CaptureSegment
    camera: Camera  # camera of the iteration's view
    first_counts: tuple[int, int]  # static and dynamic splats that the training began with
    statics_learn: bool

    @property
    def size(self) -> float:
        """The factor by which pictures are resized in this iteration."""
        return self.schedule.resolution(self.iteration)

    def random(self, purpose: int) -> np.random.Generator:
        """Return the random numbers of this iteration for a purpose; every purpose has a number of its own."""
        return np.random.default_rng((self.seed, purpose, self.iteration))


class Round(Protocol):
    """One thing that is done to the sets between iterations."""

    name: ClassVar[str]  # name of the activity in the profile of train.json
    on_host: ClassVar[bool]  # whether the state is brought to the host first; frequent rounds run where it is

    is_long: ClassVar[bool]  # whether it may take more than a second or two: it can be interrupted then

    def due(self, iteration: int) -> bool:
        """Return whether the round follows this iteration, counted from 0."""

    def apply(self, state: TrainState, context: RoundContext) -> None:
        """Change the state in place."""


def is_after_share(config: TrainConfig, iteration: int, shares: Sequence[float]) -> bool:
    """Return whether one of these shares of all iterations ends with this one."""
    return iteration + 1 in {round(share * config.iterations) for share in shares}


def is_one_of_ten(config: TrainConfig, iteration: int) -> bool:
    """Return whether one of ten evenly spaced rounds follows this iteration, all while splats are still added."""
    first, last = (share * config.iterations for share in (_FIRST_OF_TEN, config.density.end))
    every = max(1, round((last - first) / 10))
    done = iteration + 1
    return first < done <= last and (done - round(first)) % every == 0
