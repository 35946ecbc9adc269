"""One step, against the reference rasterizer in float64: its loss, and slopes by differences or by torch."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import Gradients, ScreenStatistics, View
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.colour_correction import ColourCorrection
from hgs_core.train.step import Step, take_step
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView
from tests.synthetic import ring_of_cameras, synthetic_scene

CONFIG = TrainConfig(dssim=0.0, antialiased=True)
WIDTH, HEIGHT = 48, 32  # 3 times 2 tiles
MOMENT = 0.4

Sets = tuple[StaticSplats[Tensor], DynamicSplats[Tensor]]


@pytest.fixture
def camera() -> Camera:
    return ring_of_cameras(3, WIDTH, HEIGHT)[1]


@pytest.fixture
def view(camera: Camera) -> TrainingView:
    target = torch.rand(3, HEIGHT, WIDTH, generator=torch.Generator().manual_seed(0))
    return TrainingView(1, camera, MOMENT, target)


def step(sets: Sets, view: TrainingView, gradients: Gradients = "all", **options: Any) -> Step:
    return take_step(*sets, view, CONFIG, gradients=gradients, **options)


def drawn(sets: Sets, camera: Camera) -> Tensor:
    """The picture of the reference rasterizer, in float64."""
    static, dynamic = (splats.map(lambda array: array.detach().double()) for splats in sets)
    return rasterize_reference(static, dynamic, View(camera, MOMENT, antialiased=True)).rgb


def rgb_gradients(sets: Sets) -> list[Tensor | None]:
    return [splats.rgb.grad for splats in sets]


@pytest.mark.parametrize(
    ("gradients", "learns"), [("static", (True, False)), ("dynamic", (False, True)), ("all", (True, True))]
)
def test_only_the_sets_that_are_named_learn(
    view: TrainingView, gradients: Gradients, learns: tuple[bool, bool]
) -> None:
    sets = synthetic_scene()
    step(sets, view, gradients)
    assert tuple(gradient is not None for gradient in rgb_gradients(sets)) == learns
    assert not any(array.requires_grad for splats in sets for _, array in splats.items())


def test_the_loss_is_that_of_the_reference_picture(view: TrainingView) -> None:
    sets = synthetic_scene()
    found = step(sets, view)
    picture = drawn(sets, view.camera)
    torch.testing.assert_close(found.picture.double(), picture, atol=1e-4, rtol=0)
    assert found.loss == pytest.approx(float((picture - view.target.double()).abs().mean()), rel=1e-4)


def test_the_gradient_is_the_slope_of_the_loss(view: TrainingView) -> None:
    """Along itself, by central differences of the reference in float64: no other direction is as steep."""
    sets = synthetic_scene()
    step(sets, view, "static")
    gradient = sets[0].rgb.grad
    assert gradient is not None
    direction = gradient.double() / gradient.double().norm()

    def loss(shift: float) -> float:
        moved, dynamic = synthetic_scene()
        moved = dataclasses.replace(moved, rgb=moved.rgb + shift * direction)
        return float((drawn((moved, dynamic), view.camera) - view.target.double()).abs().mean())

    slope = (loss(1e-3) - loss(-1e-3)) / 2e-3
    assert float(gradient.norm()) == pytest.approx(slope, rel=1e-2)


def test_pixels_that_are_ignored_and_tiles_that_are_not_drawn_count_as_perfect(view: TrainingView) -> None:
    tiles = np.array([[True, False, True], [False, True, False]])
    ignored = torch.zeros(HEIGHT, WIDTH, dtype=torch.bool)
    ignored[:8] = True
    found = step(synthetic_scene(), view, tiles=tiles, ignored=ignored)
    counted = np.kron(tiles, np.ones((16, 16), bool)) & ~ignored.numpy()
    error = (drawn(synthetic_scene(), view.camera) - view.target.double()).abs().numpy()
    assert found.loss == pytest.approx((error * counted).sum() / error.size, rel=1e-4)


def test_the_camera_s_colours_are_compared_and_the_scene_s_are_returned(view: TrainingView) -> None:
    correction = ColourCorrection(3)
    correction.affine[1] = torch.tensor([[1.1, 0.0, 0.1, 0.02], [0.0, 0.9, 0.0, 0.0], [0.05, 0.0, 1.0, -0.03]])
    assert correction.falloff is not None
    correction.falloff[1] = torch.tensor([-0.2, 0.1])
    found = step(synthetic_scene(), view, correction=correction)
    picture = drawn(synthetic_scene(), view.camera)
    torch.testing.assert_close(found.picture.double(), picture, atol=1e-4, rtol=0)
    affine = correction.affine[1].double().requires_grad_()
    falloff = correction.falloff[1].double().requires_grad_()
    rows, columns = torch.meshgrid(torch.arange(HEIGHT) + 0.5, torch.arange(WIDTH) + 0.5, indexing="ij")
    centred = (rows - view.camera.cy).square() + (columns - view.camera.cx).square()
    squares = 4 * centred.double() / (HEIGHT**2 + WIDTH**2)
    lit = picture * (1 + falloff[0] * squares + falloff[1] * squares.square())
    shown = torch.einsum("ij,jhw->ihw", affine[:, :3], lit) + affine[:, 3, None, None]
    loss = (shown - view.target.double()).abs().mean()
    loss.backward()  # type: ignore[no-untyped-call]
    assert found.loss == pytest.approx(float(loss.detach()), rel=1e-4)
    assert found.colour_gradient is not None
    for gradient, expected in zip(found.colour_gradient, (affine.grad, falloff.grad), strict=True):
        assert gradient is not None
        assert expected is not None
        torch.testing.assert_close(gradient.double(), expected, rtol=1e-3, atol=1e-4)


def test_without_correction_there_is_no_gradient_of_colours(view: TrainingView) -> None:
    assert step(synthetic_scene(), view).colour_gradient is None


def test_statistics_count_the_splats_that_were_seen(view: TrainingView) -> None:
    sets = synthetic_scene()
    statistics = ScreenStatistics.zeros(len(sets[0]) + len(sets[1]))
    step(sets, view, statistics=statistics)
    step(sets, view, statistics=statistics)
    assert set(np.unique(statistics.count)) <= {0, 2}
    assert (np.asarray(statistics.count) == 2).sum() > 100
