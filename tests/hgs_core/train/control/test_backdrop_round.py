"""Statics that were pulled off their backdrop lie on it again, unless two pictures show them."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import torch

from hgs_core.points.backdrop import Backdrop
from hgs_core.points.still_depths import StillDepths
from hgs_core.scene.rotations import matrices
from hgs_core.train.control.backdrop_round import BackdropRound, laid_on, shown_once
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingViews
from tests.hgs_core.render.scenes import camera
from tests.hgs_core.train.conftest import Apply, state_of
from tests.synthetic import synthetic_scene

BACKDROP = Backdrop((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), 3.0)


def test_they_lie_in_the_surface_and_are_thin() -> None:
    static, _ = synthetic_scene()
    laid = laid_on(BACKDROP, static)
    places, normals = BACKDROP.nearest(laid.means.numpy().astype(np.float64))
    np.testing.assert_allclose(laid.means.numpy(), places, atol=1e-5)
    sizes = laid.log_scales.numpy()
    rows, thin = np.arange(len(sizes)), sizes.argmin(1)
    axes = matrices(laid.quats.numpy().astype(np.float64))[rows, :, thin]
    np.testing.assert_allclose(np.abs((axes * normals).sum(1)), 1.0, atol=1e-5)
    assert (sizes[rows, thin] <= np.sort(sizes, 1)[:, 1] + math.log(0.1) + 1e-6).all()
    assert torch.equal(laid.rgb, static.rgb)


def test_discs_of_the_floor_are_narrow_so_that_feet_behind_their_middles_show() -> None:
    static, _ = synthetic_scene()
    static.log_scales[:] = math.log(0.5)
    places, _ = BACKDROP.nearest(static.means.numpy().astype(np.float64))
    on_floor = np.abs(places[:, 1] - 1.0) < 1e-6
    assert 0 < on_floor.sum() < len(on_floor)
    longest = laid_on(BACKDROP, static).log_scales.numpy().max(1)
    np.testing.assert_allclose(longest[on_floor], math.log(0.06), rtol=1e-5)
    np.testing.assert_allclose(longest[~on_floor], math.log(0.5), rtol=1e-5)
    wide = laid_on(BACKDROP, static, wide=True).log_scales.numpy().max(1)
    np.testing.assert_allclose(wide, math.log(0.5), rtol=1e-5)


def test_what_lies_on_it_stays_as_it_is() -> None:
    static, _ = synthetic_scene()
    once = laid_on(BACKDROP, static)
    twice = laid_on(BACKDROP, once)
    for (name, one), (_, two) in zip(once.items(), twice.items(), strict=True):
        torch.testing.assert_close(one, two, atol=1e-5, rtol=0, msg=name)


def test_a_round_lays_down_every_ten_iterations_what_fewer_than_two_pictures_show(
    applied: Apply, views: TrainingViews
) -> None:
    static, dynamic = synthetic_scene()
    static.means[:] = static.means.mean(0)
    static.means[::2] += 50
    rows = shown_once(static, views.cameras)
    assert list(rows) == list(range(0, len(static), 2))
    state = state_of(static.map(torch.clone), dynamic.map(torch.clone))
    control = BackdropRound(TrainConfig(iterations=100), BACKDROP)
    assert [i for i in range(25) if control.due(i)] == [9, 19]
    applied(control, state)
    laid = laid_on(BACKDROP, static)
    for name, array in state.static.items():
        assert torch.equal(array[::2], getattr(laid, name)[::2]), name
        assert torch.equal(array[1::2], getattr(static, name)[1::2]), name
    assert torch.equal(state.dynamic.motion, dynamic.motion)


def test_what_one_camera_shows_is_held_at_its_given_depth() -> None:
    static, _ = synthetic_scene()
    view = camera(64, 48)
    static.log_scales[:] = math.log(0.5)
    static.means[:] = torch.tensor([30.0, 0.0, 3.0])
    in_front = view.position + view.rays(np.array([[20.5, 20.5]])) * 2.0
    static.means[0] = torch.from_numpy(in_front[0])
    depths = np.full((48, 64), 4.0, np.float32)
    given = dataclasses.replace(BACKDROP, given=StillDepths({view.name: depths}))
    laid = laid_on(given, static, [view])
    expected = view.position + view.rays(np.array([[20.5, 20.5]])) * 4.0
    np.testing.assert_allclose(laid.means[:1].numpy(), expected, atol=1e-5)
    thin = laid.log_scales[0].argmin()
    axis = matrices(laid.quats.numpy().astype(np.float64))[0, :, thin]
    assert np.abs(axis @ view.world_to_camera[2, :3]) == pytest.approx(1.0, abs=1e-4)
    assert laid.log_scales[0].max() == pytest.approx(math.log(0.5))  # a wall
    assert torch.equal(laid.means[1:], laid_on(BACKDROP, static).means[1:])


def test_discs_of_given_floors_are_narrow() -> None:
    static, _ = synthetic_scene()
    view = camera(64, 48)
    static.log_scales[:] = math.log(0.5)
    static.means[:] = torch.from_numpy(view.position + view.rays(np.array([[20.5, 20.5]])) * 2.0)
    up = tuple(float(value) for value in view.world_to_camera[2, :3])  # the camera looks straight up or down
    shape = Backdrop(tuple(float(one) for one in view.position), up, 3.0)
    given = dataclasses.replace(shape, given=StillDepths({view.name: np.full((48, 64), 2.0, np.float32)}))
    assert laid_on(given, static, [view]).log_scales.max() == pytest.approx(math.log(0.06))


@pytest.mark.parametrize(("cameras", "alone"), [(0, True), (1, True), (2, False), (3, False)])
def test_one_picture_does_not_show_where_a_splat_is(cameras: int, alone: bool) -> None:
    static, _ = synthetic_scene()
    before, beside = static.take([0]), static.take([0])
    before.means[:] = torch.tensor([0.0, 0.0, 3.0])
    beside.means[:] = torch.tensor([30.0, 0.0, 3.0])
    rig = [camera(64, 48)] * cameras
    assert len(shown_once(before, rig)) == alone
    assert len(shown_once(beside, rig)) == 1
