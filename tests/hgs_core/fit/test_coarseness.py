from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from hgs_core.capture.open import open_capture
from hgs_core.codec.encoder.preview import quantised_scene
from hgs_core.fit.coarseness import BUDGET_SHARE_NEAR_ENOUGH, Loss, _coarsest, fit
from hgs_core.fit.config import BUDGETS
from hgs_core.fit.utility import measure_utility
from hgs_core.fit.views import EncodeViews, views_around
from hgs_core.render.reference import rasterize_reference
from hgs_core.render.types import View
from hgs_core.scene import HybridScene, Segment
from hgs_core.train.config import TrainConfig
from hgs_core.train.targets import target_picture
from tests.synthetic import synthetic_scene, write_capture


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


def test_views_are_drawn_at_the_moments_when_their_pictures_were_taken(tmp_path: Path) -> None:
    cameras = write_capture(tmp_path, frames=3, late={"1": 0.5, "3": 0.5})
    capture, static_and_dynamic = open_capture(tmp_path), synthetic_scene()
    segment = Segment(0.0, 2 / 30, static_and_dynamic[1])
    given = HybridScene(static_and_dynamic[0], (segment,)).map(lambda tensor: tensor.numpy())
    views = EncodeViews(
        "", tuple(cameras), dict(enumerate(cameras)), capture.times,
        lambda camera, frame: target_picture(capture, camera, frame, cameras[camera]), capture,
    )  # fmt: skip
    assert Loss(given, views, {1: cameras[1]})._psnr.min() > 41


def test_settings_keep_the_training_views_within_the_budget(tmp_path: Path) -> None:
    cameras = write_capture(tmp_path)
    given, capture = scene(), open_capture(tmp_path)
    views = EncodeViews(
        "", tuple(cameras), dict(enumerate(cameras)), capture.times,
        lambda camera, frame: target_picture(capture, camera, frame, cameras[camera]),
    )  # fmt: skip
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


def test_without_pictures_the_scene_itself_is_what_is_compared_with(tmp_path: Path) -> None:
    given = scene()
    views = views_around(given, "cloud")
    loss = Loss(given, views, views.trained)
    assert loss.of(given) == 0
    darker = type(given)(dataclasses.replace(given.static, rgb=given.static.rgb * 0.9), given.segments)
    assert 0.1 < loss.of(darker) < 10


def test_without_pictures_a_loss_shows_on_any_background(tmp_path: Path) -> None:
    """Black splats before nothing do not show on black."""
    given = scene()
    black = type(given)(dataclasses.replace(given.static, rgb=np.zeros_like(given.static.rgb)), given.segments)
    views = views_around(black, "cloud")
    loss = Loss(black, views, views.trained)
    assert loss.of(black) == 0
    fewer = type(given)(black.static.take(slice(0, 75)), given.segments)
    assert loss.of(fewer) > 3
