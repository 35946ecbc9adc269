"""Which dynamic splats stand still, and how labels change without changing the picture."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor

from hgs_core.render import rasterize
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.control.relabelling import LabelRound, as_dynamics, as_statics, standing_still
from hgs_core.train.train_config import LabelConfig
from tests.hgs_core.train.conftest import CONFIG, state_of
from tests.synthetic import ring_of_cameras, synthetic_scene

CAMERAS = ring_of_cameras(3, 64, 48)  # three units from the origin, 76.8 pixels of focal length: 26 pixels per unit


def resting(count: int = 1, precision: float = 1e-3) -> DynamicSplats[Tensor]:
    """Splats at the origin that do nothing, visible for a long time."""
    rotation = torch.zeros(count, 2, 4)
    rotation[:, 0, 0] = 1
    return DynamicSplats(
        torch.zeros(count, 4, 3),
        rotation,
        torch.log(torch.tensor([0.2, 0.1, 0.05])).repeat(count, 1),
        torch.ones(count),
        torch.full((count,), 0.5),
        torch.full((count,), math.log(precision)),
        torch.full((count, 3), 0.6),
    )


def test_a_splat_that_does_nothing_stands_still() -> None:
    assert standing_still(resting(), CAMERAS, 0.25).tolist() == [True]


@pytest.mark.parametrize("power", [1, 2, 3])
@pytest.mark.parametrize(("travel", "still"), [(0.004, True), (0.05, False)])
def test_moving_less_than_the_threshold_on_every_screen_is_standing_still(
    power: int, travel: float, still: bool
) -> None:
    dynamic = resting()
    dynamic.motion[0, power, 0] = travel / 0.5**power  # travel between the middle and the ends of the segment
    assert standing_still(dynamic, CAMERAS, 0.25).tolist() == [still]


def test_turning_moves_the_ends_of_the_axes() -> None:
    dynamic = resting()
    dynamic.rotation[0, 1, 3] = 1.0
    assert standing_still(dynamic, CAMERAS, 0.25).tolist() == [False]
    assert standing_still(dynamic, CAMERAS, 10.0).tolist() == [True]


def test_fading_is_not_standing_still() -> None:
    assert standing_still(resting(precision=10.0), CAMERAS, 0.25).tolist() == [False]


def test_an_empty_set_has_nothing_that_stands_still() -> None:
    assert standing_still(resting(0), CAMERAS, 0.25).shape == (0,)


def picture(static: StaticSplats[Tensor] | None, dynamic: DynamicSplats[Tensor] | None, time: float) -> np.ndarray:
    return rasterize(static, dynamic, CAMERAS[1], time, gradients="none").rgb.numpy()


@pytest.mark.parametrize("time", [0.0, 0.5, 1.0])
def test_folding_motion_in_hardly_changes_the_picture(time: float) -> None:
    dynamic = resting()
    dynamic.motion[0, 1] = torch.tensor([0.002, 0.0, -0.001])
    np.testing.assert_allclose(picture(as_statics(dynamic), None, time), picture(None, dynamic, time), atol=5e-3)


def test_a_static_splat_is_divided_into_two_lives_that_overlap() -> None:
    static = as_statics(resting(2))
    assert as_dynamics(static, 6).motion.shape == (4, 6, 3)
    lives = as_dynamics(static)
    assert len(lives) == 4
    assert lives.time_centers.tolist() == [0.25, 0.25, 0.75, 0.75]
    torch.testing.assert_close(lives.motion[:, 0], static.means.repeat(2, 1))
    for time in (0.25, 0.5, 0.75):  # opacity within a fifth
        one, two = picture(static, None, time), picture(None, lives, time)
        assert np.abs(one - two).max() < 0.2


def test_labels_move_splats_between_the_sets(applied: Callable[..., None]) -> None:
    static, dynamic = synthetic_scene()
    still = dynamic.map(Tensor.clone)  # the first one stands still, and is visible all the time
    still.motion[0, 1:] = 0
    still.time_log_precisions[0] = -9.0
    state = state_of(static, still)
    config = dataclasses.replace(CONFIG, labels=LabelConfig(restless_error=0.0))
    applied(LabelRound(config), state, config)
    assert (len(state.static), len(state.dynamic)) == (len(static) + 1, len(dynamic) - 1)
    torch.testing.assert_close(state.static.means[-1], still.motion[0, 0])
    assert state.history.labels_changed == {"to_static": 1, "to_dynamic": 0}


def test_a_static_splat_in_the_way_of_motion_becomes_dynamic(applied: Callable[..., None]) -> None:
    static, dynamic = synthetic_scene()
    state = state_of(static, dynamic.take(slice(0, 0)))  # no dynamics: statics must stand in
    config = dataclasses.replace(CONFIG, labels=LabelConfig(restless_error=0.005))
    applied(LabelRound(config), state, config)
    changed = state.history.labels_changed["to_dynamic"]
    assert 0 < changed <= 0.02 * len(static)
    assert len(state.dynamic) == 2 * changed
    assert len(state.static) == len(static) - changed
