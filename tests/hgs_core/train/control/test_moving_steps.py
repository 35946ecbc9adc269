"""Further steps of the dynamics alone, in the tiles where something moves."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
import torch

from hgs_core.render import rasterize
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.moving_steps import MovingSteps
from hgs_core.train.training_views import TrainingViews
from tests.hgs_core.train.conftest import CONFIG, state_of
from tests.synthetic import synthetic_scene

Applied = Callable[..., None]
STEPS = dataclasses.replace(CONFIG, moving_steps=0.3, coarse_until=0.0)


@pytest.fixture
def state() -> TrainState:
    static, dynamic = synthetic_scene()
    made = state_of(static.map(torch.clone), dynamic.map(torch.clone))
    made.dynamic.rgb[:] = 0.5  # all that is wrong
    return made


def moving_error(state: TrainState, views: TrainingViews) -> float:
    total = []
    for view, moving in views.where_it_moves(7, 20, 1.0):
        picture = rasterize(state.static, state.dynamic, view.camera, view.moment, antialiased=True).rgb
        total.append(float((moving.cut(picture) - view.target)[:, moving.drawn()].square().mean()))
    return float(np.mean(total))


def test_they_mend_what_moves_and_leave_statics_as_they_are(
    state: TrainState, views: TrainingViews, applied: Applied
) -> None:
    before, static = moving_error(state, views), state.static.map(torch.clone)
    applied(MovingSteps(STEPS), state, STEPS)
    assert moving_error(state, views) < 0.8 * before
    for (name, was), (_, now) in zip(static.items(), state.static.items(), strict=True):
        assert torch.equal(was, now), name
    assert state.static_optimiser.steps == 0
    assert 0 < state.dynamic_optimiser.steps <= 30


def test_what_was_seen_counts_for_density_control(state: TrainState, applied: Applied) -> None:
    applied(MovingSteps(STEPS), state, STEPS)
    statics = len(state.static)
    assert not state.statistics.count[:statics].any()
    assert state.statistics.count[statics:].any()


def test_nothing_is_counted_once_no_round_refines(state: TrainState, applied: Applied) -> None:
    late = dataclasses.replace(STEPS, density=dataclasses.replace(STEPS.density, start=0.0, end=0.0))
    applied(MovingSteps(late), state, late)
    assert state.dynamic_optimiser.steps > 0
    assert not state.statistics.count.any()


def test_equal_iterations_take_equal_steps(state: TrainState, applied: Applied) -> None:
    again = state_of(state.static.map(torch.clone), state.dynamic.map(torch.clone))
    for each in (state, again):
        applied(MovingSteps(STEPS), each, STEPS)
    for (name, one), (_, two) in zip(state.dynamic.items(), again.dynamic.items(), strict=True):
        assert torch.equal(one, two), name
