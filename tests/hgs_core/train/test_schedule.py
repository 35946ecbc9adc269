"""Step sizes, resolution and budgets over a run."""

from __future__ import annotations

import dataclasses

import pytest
import torch

from hgs_core.scene.splats import DynamicSplats
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.schedule import Schedule
from hgs_core.train.train_config import LearningRates, TrainConfig

CONFIG = TrainConfig(
    learning_rates=LearningRates(position=1e-3, position_final=1e-5),
    iterations=1000,
    coarse_until=0.25,
    hold_from=1.0,
    density=DensityConfig(start=0.1, end=0.6, every=100, max_static=5000),
)


def test_positions_decay_from_first_to_final_rate_in_units_of_the_extent() -> None:
    schedule = Schedule(CONFIG, extent=2.0, frames=50)
    assert schedule.static_rates(0)["means"] == pytest.approx(2e-3)
    assert schedule.static_rates(500)["means"] == pytest.approx(2 * (1e-3 * 1e-5) ** 0.5)
    assert schedule.static_rates(1000)["means"] == pytest.approx(2e-5)


def lives(*precisions: float, coefficients: int = 4) -> DynamicSplats[torch.Tensor]:
    """Dynamic splats of the given temporal precisions s."""
    count = len(precisions)
    return DynamicSplats(
        torch.zeros(count, coefficients, 3),
        torch.zeros(count, 2, 4),
        torch.zeros(count, 3),
        torch.zeros(count),
        torch.zeros(count),
        torch.tensor(precisions).log(),
        torch.zeros(count, 3),
    )


def test_a_step_of_any_motion_coefficient_moves_a_splat_as_far_at_the_ends_of_its_life() -> None:
    config = dataclasses.replace(CONFIG, steps_by_life=False)
    rates = Schedule(config, extent=1.0, frames=50).dynamic_rates(0, lives(1.0, 100.0))
    motion, turning = rates["motion"], rates["rotation"]
    assert isinstance(motion, torch.Tensor)
    assert isinstance(turning, torch.Tensor)
    life = torch.tensor([1.0, 0.1])[:, None]
    torch.testing.assert_close(
        motion[:, :, 0] * life ** torch.arange(4), 1e-3 * torch.tensor([1.0, 0.4, 0.4, 0.4]).repeat(2, 1)
    )
    torch.testing.assert_close(turning[:, 1, 0] * life[:, 0], torch.full((2,), CONFIG.learning_rates.turning))


def test_lives_count_as_no_shorter_than_a_frame_and_no_longer_than_the_segment() -> None:
    config = dataclasses.replace(CONFIG, steps_by_life=False)
    rates = Schedule(config, extent=1.0, frames=51).dynamic_rates(0, lives(1e-4, 1e9))
    motion = rates["motion"]
    assert isinstance(motion, torch.Tensor)
    assert motion[:, 1, 0].tolist() == pytest.approx([0.4e-3, 50 * 0.4e-3])


@pytest.mark.parametrize(("order", "coefficients"), [(1, 4), (2, 4), (3, 4), (3, 6), (5, 6)])
def test_coefficients_beyond_the_order_of_motion_never_move(order: int, coefficients: int) -> None:
    config = dataclasses.replace(CONFIG, motion_order=order, steps_by_life=False)
    splats = lives(1.0, 100.0, coefficients=coefficients)
    motion = Schedule(config, 1.0, 50).dynamic_rates(0, splats)["motion"]
    assert isinstance(motion, torch.Tensor)
    assert motion.shape == (2, coefficients, 1)
    assert [bool(rate > 0) for rate in motion[0, :, 0]] == [k <= order for k in range(coefficients)]
    assert motion[1, order, 0] == pytest.approx(0.4e-3 * 10**order)


def test_clocks_step_by_parts_of_a_frame_from_a_tenth_of_the_training_on() -> None:
    schedule = Schedule(CONFIG, 1.0, 51, seconds=2.0)
    frame = 2.0 / 50
    rates = [schedule.time_shift_rate(iteration) / frame for iteration in (0, 99, 100, 500, 1000)]
    assert rates == pytest.approx([0.0, 0.0, 0.009, 0.005, 0.0])


def test_pictures_are_coarse_first() -> None:
    schedule = Schedule(CONFIG, 1.0, 50)
    assert [schedule.resolution(c) for c in (0, 249, 250, 999)] == [0.5, 0.5, 1.0, 1.0]


def test_the_budget_grows_to_its_limit() -> None:
    schedule = Schedule(CONFIG, 1.0, 50)
    assert schedule.budget(599, 1000, 5000) == 5000
    assert schedule.budget(299, 1000, 5000) == 3000
    assert schedule.budget(599, 8000, 5000) == 8000


def test_pulls_count_until_the_last_round_that_refines() -> None:
    schedule = Schedule(CONFIG, extent=1.0, frames=50)
    assert schedule.are_pulls_counted(599)
    assert not schedule.are_pulls_counted(600)


def test_steps_of_all_but_positions_settle_to_the_share_that_is_left() -> None:
    schedule = Schedule(dataclasses.replace(CONFIG, settle_from=0.5, settled=0.1), extent=2.0, frames=50)
    shares = [schedule.settling(iteration) for iteration in (0, 500, 750, 1000)]
    assert shares == pytest.approx([1.0, 1.0, 0.55, 0.1])
    first, last = (schedule.static_rates(iteration) for iteration in (0, 1000))
    assert all(last[name] == pytest.approx(0.1 * float(first[name])) for name in first if name != "means")
    first, last = (schedule.dynamic_rates(iteration, lives(4.0)) for iteration in (0, 1000))
    for name in ("rotation", "log_scales", "opacity_logits", "time_centers", "time_log_precisions", "rgb"):
        torch.testing.assert_close(torch.as_tensor(last[name]), 0.1 * torch.as_tensor(first[name]))


def test_steps_that_are_held_stay_as_large_and_those_of_statics_become_a_multiple() -> None:
    falling = Schedule(dataclasses.replace(CONFIG, settle_from=0.5), extent=2.0, frames=50)
    held = Schedule(
        dataclasses.replace(CONFIG, settle_from=0.5, hold_from=0.8, held_statics=2.5), extent=2.0, frames=50
    )
    then, still = falling.static_rates(800), falling.dynamic_rates(800, lives(4.0))
    assert held.static_rates(800) == then
    for iteration in (801, 999):
        assert held.static_rates(iteration) == pytest.approx({name: 2.5 * rate for name, rate in then.items()})
        for name, rate in held.dynamic_rates(iteration, lives(4.0)).items():
            torch.testing.assert_close(rate, still[name], msg=name)
        assert held.position_rate(iteration) == falling.position_rate(800)


def test_steps_of_the_first_iteration_are_whole_even_if_all_are_held() -> None:
    """Fine-tuning takes these (`hgs_core/fit/fine_tune.py`)."""
    held = Schedule(dataclasses.replace(CONFIG, hold_from=0.0), extent=2.0, frames=50)
    assert held.static_rates(0) == Schedule(CONFIG, extent=2.0, frames=50).static_rates(0)


@pytest.mark.parametrize(
    ("iterations", "share", "expected"),
    [(100, 0.7, [80, 90, 100]), (45, 0.5, [25, 35, 45]), (100, 1.0, []), (3, 0.9, [3])],
)
def test_every_tenth_of_the_last_splats_counts_for_the_mean(iterations: int, share: float, expected: list[int]) -> None:
    schedule = Schedule(dataclasses.replace(CONFIG, iterations=iterations, average_from=share), 1.0, 50)
    assert [done for done in range(1, iterations + 1) if schedule.is_averaged(done)] == expected
