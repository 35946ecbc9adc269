"""Dynamic splats in and out of the hull of a walking body that three cameras see."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import torch

from hgs_core.points.backdrop import Backdrop
from hgs_core.scene.camera import Camera
from hgs_core.scene.splats import DynamicSplats
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.hull_round import HullRound
from hgs_core.train.control.round import RoundContext
from hgs_core.train.train_config import TrainConfig
from tests.hgs_core.train.conftest import state_of
from tests.synthetic import synthetic_scene
from tests.walking_body import CAMERAS, body, mask_of

FRAMES = 5
BACKDROP = Backdrop((0.0, 0.6, 0.0), (0.0, -1.0, 0.0), 4.0)
MIDDLE = body(0.0).mean(0)
SIZE = math.log(0.01)


def state(*places: Any, log_scales: Any = (SIZE, SIZE, SIZE)) -> TrainState:
    count = len(places)
    motion = torch.zeros(count, 4, 3)
    motion[:, 0] = torch.tensor(np.array(places), dtype=torch.float32)
    rotation = torch.zeros(count, 2, 4)
    rotation[:, 0, 0] = 1
    dynamic = DynamicSplats(
        motion,
        rotation,
        torch.tensor([log_scales] * count),
        torch.zeros(count),
        torch.full((count,), 0.5),
        torch.zeros(count),
        torch.zeros(count, 3),
    )
    return state_of(synthetic_scene()[0].map(torch.clone), dynamic)


def apply(state: TrainState, cameras: tuple[Camera, ...] = CAMERAS) -> list[list[float]]:
    """The places [M, 3] of the splats that stay, in a body that stands."""
    masks = [mask_of(camera, body(0.0)) for camera in cameras]
    views = SimpleNamespace(cameras=cameras, moving=lambda frame: masks)
    context = SimpleNamespace(views=views, segment=SimpleNamespace(frames=FRAMES), random=np.random.default_rng)
    HullRound(TrainConfig(iterations=400), BACKDROP).apply(state, cast(RoundContext, context))
    assert len(state.dynamic_optimiser.moments) == len(state.dynamic)
    return cast("list[list[float]]", state.dynamic.motion[:, 0].tolist())


def test_what_lies_outside_goes_and_is_counted() -> None:
    made = state(MIDDLE, MIDDLE + np.array((0.5, 0, 0)), MIDDLE + np.array((0, 0, 0.5)))
    np.testing.assert_allclose(apply(made), [MIDDLE], atol=1e-6)
    assert made.history.pruned == 2


def test_axes_that_stick_out_become_shorter() -> None:
    made = state(MIDDLE, log_scales=(math.log(0.4), SIZE, math.log(0.05)))
    apply(made)
    long, *others = made.dynamic.log_scales[0].tolist()
    assert long == np.float32(math.log(0.4) + math.log(0.8))
    np.testing.assert_allclose(others, [SIZE, math.log(0.05)], rtol=1e-6)


def test_what_one_camera_alone_shows_stays_above_or_below_what_two_show() -> None:
    near, far, high = 1.0 * CAMERAS[0].position, 0.4 * CAMERAS[0].position, MIDDLE + np.array((0, 0.45, 0))
    cut = (CAMERAS[0], *(_cut(camera) for camera in CAMERAS[1:]))
    ray = high - near
    nearer = near + 0.6 * ray  # the same pixel
    kept = apply(state(MIDDLE, MIDDLE + np.array((0.03, 0.05, 0.03)), high, nearer, far), cut)
    np.testing.assert_allclose(kept, [MIDDLE, MIDDLE + np.array((0.03, 0.05, 0.03)), high], atol=1e-6)


def _cut(camera: Camera) -> Camera:
    """The camera with a picture that ends above the feet."""
    return dataclasses.replace(camera, height=140)


def test_rounds_are_due_every_fortieth_of_the_training_but_at_first() -> None:
    control = HullRound(TrainConfig(iterations=400), BACKDROP)
    assert [i for i in range(70) if control.due(i)] == [49, 59, 69]
