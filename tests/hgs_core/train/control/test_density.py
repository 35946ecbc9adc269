"""Density control: pruned, cloned and split splats, with optimiser and labels in step."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.render.types import ScreenStatistics
from hgs_core.scene import DynamicSplats, StaticSplats
from hgs_core.train.control.density import DensityPlan, DensityRound, refine
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.train_config import LabelConfig, TrainConfig
from tests.hgs_core.render.scenes import dynamic_splats, static_splats

EXTENT = 100.0


def plan(budget: int = 1000, split_scale: float = 0.1) -> DensityPlan:
    config = TrainConfig(density=DensityConfig(clone_scale=split_scale / EXTENT))
    return DensityPlan(budget, EXTENT, 1.0, config, torch.Generator().manual_seed(0))


def pulls(values: list[float]) -> ScreenStatistics:
    return ScreenStatistics(np.array(values, np.float32) * 2, np.full(len(values), 2, np.int32))


def test_rounds_lie_every_so_often_between_their_first_and_last_share() -> None:
    config = TrainConfig(iterations=200, density=DensityConfig(start=0.25, end=0.6, every=30))
    assert [i + 1 for i in range(200) if DensityRound(config).due(i)] == [60, 90, 120]


def visible_statics(count: int) -> StaticSplats[Tensor]:
    splats = static_splats(count, dtype=torch.float32)
    return dataclasses.replace(splats, opacity_logits=torch.zeros(count))


def test_transparent_splats_are_pruned_and_moments_follow() -> None:
    splats = visible_statics(4)
    splats.opacity_logits[1] = -9.0
    optimiser = RmsProp.of(splats)
    optimiser.moments.means[:] = torch.arange(4.0)[:, None]
    result = refine(splats, optimiser, pulls([0, 0, 0, 0]), plan())
    torch.testing.assert_close(result.means, splats.means[[0, 2, 3]])
    assert optimiser.moments.means[:, 0].tolist() == [0, 2, 3]


def test_a_dynamic_splat_that_is_fog_is_pruned_unless_all_splats_are_dynamic() -> None:
    splats = dataclasses.replace(dynamic_splats(3, dtype=torch.float32), opacity_logits=torch.zeros(3))
    splats.log_scales[:] = math.log(0.01)
    splats.log_scales[1, 2] = math.log(0.31 * EXTENT)
    splats.time_log_precisions[:] = 0.0
    for labels, kept in (("auto", [0, 2]), ("dynamic", [0, 1, 2])):
        config = dataclasses.replace(plan(), config=TrainConfig(labels=LabelConfig(initial=labels)))
        result = refine(splats, RmsProp.of(splats), pulls([0.0] * 3), config)
        torch.testing.assert_close(result.motion, splats.motion[kept])
    statics = dataclasses.replace(visible_statics(1), log_scales=torch.full((1, 3), math.log(0.31 * EXTENT)))
    assert len(refine(statics, RmsProp.of(statics), pulls([0.0]), plan())) == 1


def test_a_small_pulled_splat_is_cloned_and_the_pair_covers_as_much() -> None:
    splats = visible_statics(2)
    splats.log_scales[:] = math.log(0.01)
    optimiser = RmsProp.of(splats)
    result = refine(splats, optimiser, pulls([1.0, 0.0]), plan())
    assert len(result) == len(optimiser.moments) == 3
    torch.testing.assert_close(result.means[2], splats.means[0])
    opacity = torch.sigmoid(result.opacity_logits)
    assert 1 - (1 - float(opacity[0])) * (1 - float(opacity[2])) == pytest.approx(0.5, abs=1e-6)


def test_a_large_pulled_splat_becomes_two_smaller_ones_near_it() -> None:
    splats = visible_statics(1)
    splats.log_scales[:] = math.log(0.5)
    result = refine(splats, RmsProp.of(splats), pulls([1.0]), plan())
    assert len(result) == 2
    torch.testing.assert_close(result.log_scales, torch.full((2, 3), math.log(0.5 / 1.6)))
    assert (result.means - splats.means).norm(dim=1).max() < 0.5 * 5


def test_the_budget_goes_to_the_strongest_pulls() -> None:
    splats = visible_statics(4)
    splats.log_scales[:] = math.log(0.01)
    result = refine(splats, RmsProp.of(splats), pulls([0.1, 0.4, 0.3, 0.2]), plan(budget=6))
    assert len(result) == 6
    torch.testing.assert_close(result.means[4:], splats.means[[1, 2]])


def test_a_full_budget_adds_nothing_but_still_prunes() -> None:
    splats = visible_statics(4)
    splats.opacity_logits[0] = -9.0
    assert len(refine(splats, RmsProp.of(splats), pulls([1.0] * 4), plan(budget=2))) == 3


def test_a_splat_that_lives_outside_the_segment_is_pruned() -> None:
    splats = dynamic_splats(3, dtype=torch.float32)
    splats.opacity_logits[:] = 3.0
    splats.time_centers[:] = torch.tensor([0.5, -1.0, 1.01])
    splats.time_log_precisions[:] = math.log(100.0)
    result = refine(splats, RmsProp.of(splats), pulls([0.0] * 3), plan())
    assert isinstance(result, DynamicSplats)
    torch.testing.assert_close(result.time_centers, torch.tensor([0.5, 1.01]))


def test_children_of_dynamic_splats_are_dynamic_and_move_alike() -> None:
    splats = dynamic_splats(2, dtype=torch.float32)
    splats.opacity_logits[:] = 3.0
    splats.log_scales[:] = math.log(0.5)
    result = refine(splats, RmsProp.of(splats), pulls([1.0, 0.0]), plan())
    assert isinstance(result, DynamicSplats)
    torch.testing.assert_close(result.motion[1:, 1:], splats.motion[[0, 0], 1:])


def test_a_splat_with_nan_is_removed() -> None:
    splats = visible_statics(3)
    splats.means[1, 2] = math.nan
    assert len(refine(splats, RmsProp.of(splats), pulls([0.0] * 3), plan())) == 2


def test_equal_generators_give_equal_bits() -> None:
    results = []
    for _ in range(2):
        splats = visible_statics(20)
        results.append(refine(splats, RmsProp.of(splats), pulls([1.0] * 20), plan()))
    for (_, one), (_, two) in zip(results[0].items(), results[1].items(), strict=True):
        assert torch.equal(one, two)
