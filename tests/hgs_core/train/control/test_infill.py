"""New statics where still pixels are wrong."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.points.sweep import depth_ranges
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.control import infill as module
from hgs_core.train.control.infill import InfillRound, find_infill
from hgs_core.train.density_config import DensityConfig
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingView
from tests.balls import BALL, CAMERAS, RADIUS, balls, pictures
from tests.hgs_core.render.scenes import dynamic_splats
from tests.hgs_core.train.conftest import CONFIG, state_of
from tests.synthetic import synthetic_scene
from tests.worker_threads import threads_of

OTHER = np.array([-0.5, 0.0, 0.2])
NOTHING: DynamicSplats[Tensor] = dynamic_splats(0, dtype=torch.float32)


def infill(shown: StaticSplats[Tensor], most: int = 100, moving: bool = False, gain: float = 1.0) -> np.ndarray:
    """Points found when there are two balls and `shown` is drawn; cameras see colours times `gain`."""
    mask = torch.ones(96, 128, dtype=torch.bool) if moving else None
    views = [
        [TrainingView(place, camera, time, gain * picture.clamp(0, 1), mask) for time in (0.0, 1.0)]
        for place, (camera, picture) in enumerate(zip(CAMERAS, pictures(balls(BALL, OTHER), grey=0), strict=True))
    ]
    ranges = depth_ranges(CAMERAS, np.random.default_rng(1).uniform(-1, 1, (200, 3)))
    cloud = find_infill(
        shown,
        NOTHING,
        views,
        TrainConfig(antialiased=False),
        lambda picture, _: gain * picture,
        ranges,
        most,
        np.random.default_rng(2),
    )
    assert (cloud.dynamic == 0).all()
    return cloud.xyz


def test_what_is_missing_is_filled_in_where_it_is() -> None:
    xyz = infill(balls(BALL))
    assert len(xyz) > 20
    assert np.median(np.abs(np.linalg.norm(xyz - OTHER, axis=1) - RADIUS)) < 0.08


def test_nothing_is_added_where_the_picture_is_right() -> None:
    assert len(infill(balls(BALL, OTHER))) == 0


def test_the_colours_of_cameras_are_no_error() -> None:
    assert len(infill(balls(BALL, OTHER), gain=0.6)) == 0


def test_what_moves_is_left_to_the_dynamics() -> None:
    assert len(infill(balls(BALL), moving=True)) == 0


def test_no_more_are_added_than_there_is_room_for() -> None:
    assert len(infill(balls(BALL), most=7)) == 7


def test_statics_are_added_where_still_pixels_are_wrong_within_the_budget(applied: Callable[..., None]) -> None:
    static, dynamic = synthetic_scene()
    state = state_of(static.take(slice(0, 60)), dynamic)
    config = dataclasses.replace(CONFIG, density=DensityConfig(infill=0.1, max_static=100))
    applied(InfillRound(config), state, config)
    assert 60 < len(state.static) <= 70
    assert state.history.infilled == len(state.static) - 60


def test_cameras_are_looked_at_on_all_cores_to_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    threads = threads_of(monkeypatch, module, "picture_error")
    found = []
    for count in ("1", "4"):
        monkeypatch.setenv("HGS_THREADS", count)
        found.append(infill(balls(BALL)))
    np.testing.assert_array_equal(*found)
    assert threads
    assert "MainThread" not in threads
