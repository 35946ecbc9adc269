"""The schedule of rounds, against iterations written out by hand; their random numbers."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.train.control import RoundContext
from hgs_core.train.control.round import is_after_share, is_one_of_ten
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.schedule import Schedule
from hgs_core.train.segment_cuts import CaptureSegment
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingViews

CONFIG = TrainConfig(iterations=200, density=DensityConfig(start=0.25, end=0.6, every=30))


@pytest.fixture
def context(views: TrainingViews, segment: CaptureSegment) -> RoundContext:
    schedule = Schedule(CONFIG, extent=1.0, frames=6)
    return RoundContext(7, 3, schedule, views, segment, views.cameras[0], (1, 1), True)


def test_a_share_ends_with_one_iteration() -> None:
    assert [i + 1 for i in range(200) if is_after_share(CONFIG, i, (0.001, 0.3, 0.8))] == [60, 160]


def test_ten_rounds_lie_evenly_after_the_first_tenth() -> None:
    found = [i + 1 for i in range(200) if is_one_of_ten(CONFIG, i)]
    assert found == [30, 40, 50, 60, 70, 80, 90, 100, 110, 120]


def test_few_iterations_have_a_round_each() -> None:
    config = dataclasses.replace(CONFIG, iterations=10)  # first tenth to 0.6: five iterations
    assert [i + 1 for i in range(10) if is_one_of_ten(config, i)] == [2, 3, 4, 5, 6]


def test_random_numbers_are_the_same_again_for_the_same_seed_purpose_and_iteration(context: RoundContext) -> None:
    drawn = context.random(5).uniform(size=8)
    np.testing.assert_array_equal(drawn, context.random(5).uniform(size=8))
    changed = [
        context.random(6),
        dataclasses.replace(context, seed=4).random(5),
        dataclasses.replace(context, iteration=8).random(5),
    ]
    for other in changed:
        assert not np.array_equal(drawn, other.uniform(size=8))
