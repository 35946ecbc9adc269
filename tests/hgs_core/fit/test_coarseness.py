from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.capture.open import open_capture
from hgs_core.codec.encoder.decoded_preview import quantised_scene
from hgs_core.fit.coarseness import BUDGET_SHARE_NEAR_ENOUGH, Fitted, _coarsest, fit
from hgs_core.fit.encoding_loss import Decibels, Loss
from hgs_core.fit.encoding_views import EncodeViews
from hgs_core.fit.fit_config import BUDGETS
from hgs_core.fit.measured_utility import measure_utility
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.train.targets import target_picture
from hgs_core.train.train_config import TrainConfig
from tests.synthetic import event_splats, ring_of_cameras, synthetic_scene, write_capture


def scene() -> HybridScene[np.ndarray]:
    static, dynamic = synthetic_scene()
    return HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())


@pytest.mark.parametrize(("allowed", "curve"), [(0.1, 2.0), (0.5, 1.4), (0.02, 3.0)])
def test_the_coarsest_that_fits_is_found_whatever_the_curve(allowed: float, curve: float) -> None:
    tried = []

    def lost(coarseness: float) -> float:
        tried.append(coarseness)
        return 0.3 * coarseness**curve

    found, loss = _coarsest(lost, allowed, 0.4)
    assert BUDGET_SHARE_NEAR_ENOUGH * allowed <= loss <= allowed
    assert len(tried) <= 5
    assert loss == lost(found)


@pytest.mark.parametrize(("loss", "expected"), [(0.0, 8.0), (3.0, 0.1)])
def test_the_coarsest_stays_within_its_range(loss: float, expected: float) -> None:
    assert _coarsest(lambda coarseness: loss, 0.1, 1.0) == (expected, loss)


def test_settings_keep_the_training_views_within_the_budget(tmp_path: Path) -> None:
    cameras = write_capture(tmp_path)
    given, capture = scene(), open_capture(tmp_path)
    views = EncodeViews(
        "",
        tuple(cameras),
        dict(enumerate(cameras)),
        capture.times,
        lambda camera, frame: target_picture(capture, camera, frame, cameras[camera]),
    )
    utility = measure_utility(given, cameras, capture.times)
    found = fit(given, views, utility, "default", TrainConfig(antialiased=False))
    assert found.scene is given
    quantised = quantised_scene(given, cameras, capture.times, utility, found.settings).decoded
    drawn = {name: [] for name in ("before", "after")}
    for camera in range(5):
        for frame, seconds in enumerate(capture.times):
            true = target_picture(capture, camera, frame, cameras[camera])
            for name, one in (("before", given), ("after", quantised)):
                segment = one.segments[0].dynamic.map(torch.from_numpy)
                view = View(cameras[camera], one.segments[0].normalised(float(seconds)), gradients="none")
                picture = rasterize_reference(one.static.map(torch.from_numpy), segment, view).rgb.clamp(0, 1)
                drawn[name].append(-10 * np.log10(float(((picture - true) ** 2).mean())))
    loss = np.mean(drawn["before"]) - np.mean(drawn["after"])
    assert BUDGETS["default"] == 0.1
    assert loss < 0.15  # the budget is of twelve of these thirty views


def moving_ball() -> HybridScene[np.ndarray]:
    """The cloud, and before it a ball of bright splats that moves from left to right."""
    ball = event_splats().map(lambda tensor: tensor.numpy())
    motion, rotation = np.zeros((len(ball), 4, 3)), np.zeros((len(ball), 2, 4))
    motion[:, 0], motion[:, 1, 0], rotation[:, 0, 0] = ball.means, 0.3, 1.0
    alike = np.ones(len(ball))
    splats = DynamicSplats(
        motion, rotation, ball.log_scales, ball.opacity_logits, 0.5 * alike, -8.0 * alike, 0.1 + 0.8 * ball.rgb
    ).map(lambda array: array.astype(np.float32))
    return HybridScene(scene().static, (Segment(0.0, 5 / 30, splats),))


def views_of_a_sharp_mover_in_a_noisy_room(given: HybridScene[np.ndarray]) -> EncodeViews:
    """Still parts of the pictures are far from the scene, so that quantisation costs little there."""
    cameras, times = ring_of_cameras(3, 64, 48), np.arange(6) / 30
    still = dataclasses.replace(given, segments=(Segment(0.0, 5 / 30, DynamicSplats.empty()),))

    def picture(scene: HybridScene[np.ndarray], camera: int, frame: int) -> torch.Tensor:
        (segment,) = scene.map(torch.from_numpy).segments
        view = View(cameras[camera], segment.normalised(float(times[frame])), gradients="none")
        return rasterize_reference(scene.static.map(torch.from_numpy), segment.dynamic, view).rgb.clamp(0, 1)

    def moving(camera: int, frame: int) -> torch.Tensor:
        return (picture(given, camera, frame) - picture(still, camera, frame)).abs().amax(dim=0) > 0.02

    def truth(camera: int, frame: int) -> torch.Tensor:
        noise = torch.randn(3, 48, 64, generator=torch.Generator().manual_seed(10 * camera + frame))
        return picture(given, camera, frame) + noise * torch.where(moving(camera, frame), 0.02, 0.1)

    return EncodeViews("", tuple(cameras), dict(enumerate(cameras)), times, truth, moving=moving)


def test_what_moves_keeps_the_budget_too() -> None:
    given = moving_ball()
    views = views_of_a_sharp_mover_in_a_noisy_room(given)
    utility = measure_utility(given, list(views.cameras), views.times)
    loss = Loss(given, views, views.trained)

    def fitted(views: EncodeViews) -> tuple[Fitted, Decibels]:
        found = fit(given, views, utility, "default", TrainConfig(antialiased=False))
        return found, loss.of(quantised_scene(given, views.cameras, views.times, utility, found.settings).decoded)

    (found, lost), (unknown, lost_unknown) = fitted(views), fitted(dataclasses.replace(views, moving=None))
    assert lost_unknown.whole <= BUDGETS["default"] < 2 * BUDGETS["default"] < lost_unknown.moving
    assert (unknown.loss.moving, unknown.settings.dynamic_share) == (None, 1)
    assert found.loss == lost
    assert lost.most <= BUDGETS["default"]
    dynamic = found.settings.dynamic_share * found.settings.coarseness
    assert dynamic < unknown.settings.coarseness
    assert dynamic < 0.7 * found.settings.coarseness  # the room is not coded as finely as the mover
