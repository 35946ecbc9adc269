"""Step sizes, resolution and density rounds over a run."""

from __future__ import annotations

import pytest
import torch

from hgs_core.train.config import LearningRates, TrainConfig
from hgs_core.train.schedule import Schedule

CONFIG = TrainConfig(
    learning_rates=LearningRates(position=1e-3, position_final=1e-5),
    cycles=1000,
    coarse_until=0.25,
    densify_from=0.1,
    densify_until=0.6,
    densify_every=100,
    max_static=5000,
)


def test_positions_decay_from_first_to_final_rate_in_units_of_the_extent() -> None:
    schedule = Schedule(CONFIG, extent=2.0, frames=50)
    assert schedule.static_rates(0)["means"] == pytest.approx(2e-3)
    assert schedule.static_rates(500)["means"] == pytest.approx(2 * (1e-3 * 1e-5) ** 0.5)
    assert schedule.static_rates(1000)["means"] == pytest.approx(2e-5)


def test_motion_is_faster_in_longer_segments() -> None:
    rate = Schedule(CONFIG, extent=1.0, frames=150).dynamic_rates(0)["motion"]
    assert isinstance(rate, torch.Tensor)
    assert rate.flatten().tolist() == pytest.approx([1e-3] + [3 * 1.75 * 1e-3] * 3)


def test_pictures_are_coarse_first() -> None:
    schedule = Schedule(CONFIG, 1.0, 50)
    assert [schedule.resolution(c) for c in (0, 249, 250, 999)] == [0.5, 0.5, 1.0, 1.0]


def test_density_rounds_keep_to_their_share_of_the_run() -> None:
    schedule = Schedule(CONFIG, 1.0, 50)
    assert [c + 1 for c in range(1000) if schedule.densifies_after(c)] == [100, 200, 300, 400, 500, 600]


def test_the_budget_grows_to_its_limit() -> None:
    schedule = Schedule(CONFIG, 1.0, 50)
    assert schedule.budget(599, 1000, 5000) == 5000
    assert schedule.budget(299, 1000, 5000) == 3000
    assert schedule.budget(599, 8000, 5000) == 8000
