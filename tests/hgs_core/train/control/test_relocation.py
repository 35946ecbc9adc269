"""Relocation: copies look as one did, by the formula of Kheradmand et al. (2024), and the dead move onto the living."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.render import rasterize
from hgs_core.scene import StaticSplats
from hgs_core.scene.camera import Camera
from hgs_core.train.control.relocation import disturb, relocate, shared_among
from hgs_core.train.rmsprop import RmsProp
from hgs_core.train.splat_sets import joined
from tests.hgs_core.render.scenes import dynamic_splats, static_splats
from tests.tolerances import assert_close

DEAD = 0.005


def generator() -> np.random.Generator:
    return np.random.default_rng(0)


def statics(opacities: list[float]) -> StaticSplats[Tensor]:
    splats = static_splats(len(opacities), dtype=torch.float32)
    return dataclasses.replace(splats, opacity_logits=torch.logit(torch.tensor(opacities)))


@pytest.mark.parametrize("copies", [1, 2, 3, 10, 51])
@pytest.mark.parametrize("opacity", [0.01, 0.5, 0.99])
def test_shares_follow_equation_9(opacity: float, copies: int) -> None:
    """Reference: the double sum as the paper writes it."""
    shared, size = shared_among(np.array([opacity]), np.array([copies]))
    new = 1 - (1 - opacity) ** (1 / copies)
    total = sum(
        math.comb(i - 1, k) * (-1) ** k * new ** (k + 1) / math.sqrt(k + 1)
        for i in range(1, copies + 1)
        for k in range(i)
    )
    assert_close(shared, [new])
    assert_close(size, [opacity / total])


def test_a_line_through_the_copies_keeps_its_integral() -> None:
    """Reference: the composite of the copies' Gaussian profiles, added up numerically."""
    opacity, copies = np.array([0.9, 0.3, 0.999]), np.array([4, 7, 50_000])
    shared, size = shared_among(opacity, copies)
    x = np.linspace(-12, 12, 20001)
    for row in range(3):
        profile = 1 - (1 - shared[row] * np.exp(-((x / size[row]) ** 2) / 2)) ** copies[row]
        assert_close(profile.sum(), (opacity[row] * np.exp(-(x**2) / 2)).sum())


@pytest.mark.parametrize("copies", [2, 5])
def test_a_picture_of_copies_in_one_place_is_that_of_their_parent(copies: int) -> None:
    camera = Camera("c", 97, 97, 100, 100, 48.5, 48.5, np.eye(4))
    splats = StaticSplats(
        torch.tensor([[0.0, 0.0, 2.0]]),
        torch.full((1, 3), math.log(0.2)),
        torch.tensor([[1.0, 0, 0, 0]]),
        torch.logit(torch.tensor([0.8])),
        torch.ones(1, 3),
    )
    moved = relocate(splats, RmsProp.of(splats), copies, DEAD, generator())
    assert len(moved) == copies
    before, after = (rasterize(s, None, camera, gradients="none").alpha for s in (splats, moved))
    assert float(after[48, 48]) == pytest.approx(float(before[48, 48]), rel=1e-4)
    # Along a line the sums agree but for the tails below 1/255, which nobody draws; copies have more of these.
    assert float(after[48].sum()) == pytest.approx(float(before[48].sum()), rel=0.02)


def test_the_dead_become_copies_of_the_living_and_the_number_stays() -> None:
    splats = statics([0.5, 0.001, 0.7, 0.002])
    moved = relocate(splats, RmsProp.of(splats), 0, DEAD, generator())
    assert len(moved) == 4
    for mean in moved.means:
        assert (mean == splats.means[[0, 2]]).all(1).any()


def test_the_untouched_keep_place_and_moments_and_copies_start_anew() -> None:
    splats = statics([0.9, 0.001, 0.01])
    optimiser = RmsProp.of(splats)
    optimiser.moments.means[:] = torch.arange(1.0, 4.0)[:, None]
    moved = relocate(splats, optimiser, 0, DEAD, generator())  # the first is chosen 90 times as often as the last
    assert torch.equal(moved.means[0], splats.means[2])
    assert torch.equal(moved.means[1:], splats.means[[0, 0]])
    assert optimiser.moments.means[:, 0].tolist() == [3, 0, 0]


def test_growth_ends_at_the_budget() -> None:
    splats = statics([0.5] * 10)
    assert len(relocate(splats, RmsProp.of(splats), 13, DEAD, generator())) == 13
    assert relocate(splats, RmsProp.of(splats), 10, DEAD, generator()) is splats


def test_the_opaque_are_copied_most() -> None:
    splats = statics([0.9] * 20 + [0.02] * 80)
    moved = relocate(splats, RmsProp.of(splats), 150, DEAD, generator())
    copies = [(moved.means == mean).all(1).sum() for mean in splats.means]
    assert np.mean(copies[:20]) > 2 > 1.3 > np.mean(copies[20:])


def test_where_nothing_lives_nothing_changes() -> None:
    splats = statics([0.001, 0.002])
    assert relocate(splats, RmsProp.of(splats), 10, DEAD, generator()) is splats


def test_a_splat_with_nan_is_dead_and_never_copied() -> None:
    splats = statics([0.5, 0.9])
    splats.means[1, 0] = math.nan
    moved = relocate(splats, RmsProp.of(splats), 4, DEAD, generator())
    assert len(moved) == 4
    assert torch.isfinite(moved.means).all()


def test_copies_of_dynamic_splats_live_and_move_as_their_parent() -> None:
    splats = dynamic_splats(2, dtype=torch.float32)
    splats.opacity_logits[:] = 2.0
    splats.time_log_precisions[:] = math.log(100.0)
    splats.time_centers[:] = torch.tensor([0.4, 3.0])  # the second one lives outside the segment
    moved = relocate(splats, RmsProp.of(splats), 3, DEAD, generator())
    for name in ("motion", "rotation", "time_centers", "time_log_precisions", "rgb"):
        assert torch.equal(getattr(moved, name), getattr(splats, name)[[0, 0, 0]])
    opacity = torch.sigmoid(moved.opacity_logits)
    assert 1 - float((1 - opacity).prod()) == pytest.approx(float(torch.sigmoid(torch.tensor(2.0))), rel=1e-5)


def test_noise_moves_transparent_splats_within_their_own_shape() -> None:
    """Reference: equation 8's variance, the square of the covariance, along the axes of an unturned splat."""
    count, sizes = 4000, torch.tensor([0.1, 0.01, 0.001])
    still = StaticSplats(
        torch.zeros(count, 3),
        sizes.log().repeat(count, 1),
        torch.tensor([[1.0, 0, 0, 0]]).repeat(count, 1),
        torch.logit(torch.full((count,), 0.005)),
        torch.zeros(count, 3),
    )
    disturb(still, 1e-5, 2.0, generator())
    expected = 5e5 * 1e-5 / 2.0**2 * 0.5 * sizes**2  # the sigmoid is a half there
    torch.testing.assert_close(still.means.std(0), expected, rtol=0.05, atol=0)


def test_noise_leaves_opaque_splats_and_all_else_alone() -> None:
    opaque, faint = statics([0.5, 0.9]), dynamic_splats(2, dtype=torch.float32)
    before = opaque.means.clone()
    disturb(opaque, 1e-3, 1.0, generator())
    assert torch.equal(opaque.means, before)
    faint.opacity_logits[:] = -6.0
    motion = faint.motion.clone()
    disturb(faint, 1e-3, 1.0, generator())
    assert not torch.equal(faint.motion[:, 0], motion[:, 0])
    assert torch.equal(faint.motion[:, 1:], motion[:, 1:])


def test_equal_seeds_give_equal_bits() -> None:
    splats = joined(statics([0.5] * 20), statics([0.001] * 5))
    one, two = (relocate(splats, RmsProp.of(splats), 40, DEAD, generator()) for _ in range(2))
    for (_, first), (_, second) in zip(one.items(), two.items(), strict=True):
        assert torch.equal(first, second)
