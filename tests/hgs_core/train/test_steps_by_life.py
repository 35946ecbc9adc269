"""Splats that are alive for a part of the time move as far at each visit as those that always are."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.base.progress import silent
from hgs_core.capture.open import open_capture
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.schedule import Schedule, share_alive
from hgs_core.train.segment_cuts import cut_into_segments
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.trainer import Trainer
from tests.synthetic import write_capture

Doubles = np.ndarray

# Centre and standard deviation of the life.
CENTERS = np.array([0.5, 0.4, 0.3, 0.5, 0.2, 0.5])
WIDTHS = np.array([0.03, 0.06, 0.1, 0.2, 0.7, 1e3])


def lives(centers: Doubles, widths: Doubles) -> DynamicSplats[torch.Tensor]:
    """Dynamic splats that fade as exp(-(t - centre)^2 / (2 width^2))."""
    count = len(centers)
    return DynamicSplats(
        torch.zeros(count, 4, 3),
        torch.tensor([[[1.0, 0, 0, 0], [0, 0, 0, 0]]]).repeat(count, 1, 1),
        torch.zeros(count, 3),
        torch.zeros(count),
        torch.tensor(centers, dtype=torch.float32),
        torch.tensor(-np.log(2 * widths**2), dtype=torch.float32),
        torch.full((count, 3), 0.5),
    )


def fade(times: Doubles, centers: Doubles, widths: Doubles) -> Doubles:
    return np.exp(-((times[:, None] - centers) ** 2) / (2 * widths**2))


def moved_by_rmsprop(gradients: Doubles, rate: float) -> Doubles:
    """How far RMSprop moves each column of gradients [steps, N], in float64."""
    second, place = (np.zeros(gradients.shape[1]) for _ in range(2))
    for step, gradient in enumerate(gradients, 1):
        second += 0.001 * (gradient**2 - second)
        place += rate * gradient / (np.sqrt(second / (1 - 0.999**step)) + 1e-15)
    return place


def test_a_splat_is_alive_while_a_tenth_of_its_opacity_is_left() -> None:
    times = (np.arange(100_000) + 0.5) / 100_000
    centers, widths = np.full(4, 0.5), np.array([0.03, 0.1, 0.2, 1e3])
    truth = (fade(times, centers, widths) >= math.exp(-(1.5**2))).mean(0)
    np.testing.assert_allclose(share_alive(lives(centers, widths)).numpy(), truth, rtol=2e-3)
    assert truth[-1] == 1


def test_the_share_is_finite_for_every_life() -> None:
    precisions = torch.tensor([-1e30, -200.0, -30.0, 0.0, 30.0, 90.0, 1e30])
    share = share_alive(dataclasses.replace(lives(np.zeros(7), np.ones(7)), time_log_precisions=precisions))
    assert ((share >= 0.05) & (share <= 1)).all()
    assert (share.diff() <= 0).all()  # the shorter, the less


def test_rmsprop_alone_moves_what_is_alive_for_a_share_of_the_time_too_far_at_each_visit() -> None:
    # The derivation of docs/training.md, with lives that are there or not.
    r = np.random.default_rng(0)
    shares = np.array([1.0, 0.5, 0.2, 0.1])
    visited = r.uniform(size=(20_000, 4)) < shares
    gradients = visited * r.normal(1.0, 0.5, visited.shape)
    each = moved_by_rmsprop(gradients, 1e-3) / visited.sum(0)
    np.testing.assert_allclose(each / each[0], 1 / np.sqrt(shares), rtol=0.05)


def test_the_schedules_steps_move_a_splat_as_far_at_each_visit_as_one_that_is_always_alive() -> None:
    r = np.random.default_rng(1)
    steps = 12_000
    times, pull = r.uniform(size=steps), r.normal(1.0, 0.5, steps)
    w = fade(times, CENTERS, WIDTHS)
    splats = lives(CENTERS, WIDTHS)
    schedule = Schedule(TrainConfig(), extent=1.0, frames=60)
    rates = schedule.dynamic_rates(0, splats)
    optimiser = RmsProp.of(splats)
    for gradient in torch.tensor(-pull[:, None] * w, dtype=torch.float32):
        splats.log_scales.grad = gradient[:, None].expand(-1, 3).contiguous()
        optimiser.step(splats, rates)
    always = moved_by_rmsprop(pull[:, None], schedule.config.learning_rates.log_scale)[0] / steps
    visits = w.mean(0) ** 2 / (w**2).mean(0) * steps  # equivalent whole visits
    # A tenth of the opacity is a little later than where a life without fading would end.
    np.testing.assert_allclose(splats.log_scales[:, 0].numpy() / visits, always, rtol=0.12)
    assert visits.min() < 0.12 * steps


def test_all_fields_of_a_splat_share_its_factor() -> None:
    splats, schedule = lives(CENTERS, WIDTHS), Schedule(TrainConfig(), extent=1.0, frames=60)
    equal = Schedule(TrainConfig(steps_by_life=False), extent=1.0, frames=60).dynamic_rates(0, splats)
    for name, rate in schedule.dynamic_rates(0, splats).items():
        assert isinstance(rate, torch.Tensor)
        factor = rate / torch.as_tensor(equal[name])
        expected = share_alive(splats).sqrt().reshape(-1, *[1] * (rate.dim() - 1)).expand_as(rate)
        learns = rate > 0
        torch.testing.assert_close(factor[learns], expected[learns])


@pytest.mark.parametrize("by_life", [True, False])
def test_the_trainer_takes_steps_by_life_of_dynamic_splats_and_whole_ones_of_statics(
    by_life: bool, tmp_path: Path
) -> None:
    write_capture(tmp_path, cameras=2, frames=4, width=32, height=24)
    capture = open_capture(tmp_path)
    r = np.random.default_rng(2)
    centers, widths = np.full(12, 0.5), np.repeat([0.15, 0.2, 1e3], 4)
    dynamic = lives(centers, widths)
    dynamic.motion[:, 0] = torch.tensor(r.uniform(-0.5, 0.5, (12, 3)))
    dynamic.log_scales[:] = -1.5
    static = StaticSplats(
        torch.tensor(r.uniform(-0.5, 0.5, (8, 3)), dtype=torch.float32),
        torch.full((8, 3), -1.5),
        torch.tensor([[1.0, 0, 0, 0]]).repeat(8, 1),
        torch.zeros(8),
        torch.full((8, 3), 0.5),
    )
    density = DensityConfig(prune_contribution=0.0, static_opacity_penalty=0.0, dynamic_opacity_penalty=0.0)
    config = TrainConfig(iterations=1, coarse_until=0.0, steps_by_life=by_life, density=density)
    (segment,) = cut_into_segments(capture.times, config.segment_frames)
    before = static.opacity_logits.clone(), dynamic.opacity_logits.clone()
    training = Trainer(
        capture, dict(enumerate(capture.cameras)), config, 1, segment, (static, dynamic), tmp_path / "checkpoint.pt"
    )
    scene = training.run(silent)
    # The first step is as long as the step size, whatever the gradient.
    rate = config.learning_rates.opacity
    factor = np.sqrt(share_alive(lives(centers, widths)).numpy()) if by_life else np.ones(12)
    assert not by_life or factor[0] < 0.85
    for moved, size in (
        (scene.static.opacity_logits - before[0].numpy(), np.full(8, rate)),
        (scene.segments[0].dynamic.opacity_logits - before[1].numpy(), rate * factor),
    ):
        seen = moved != 0
        assert seen.sum() > len(moved) / 2
        np.testing.assert_allclose(np.abs(moved[seen]), size[seen], rtol=1e-4)
