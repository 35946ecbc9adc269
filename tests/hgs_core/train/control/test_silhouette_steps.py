"""Steps of movers over random colours: opaque in the masks, gone outside of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
import torch

from hgs_core.points.hull_surface import hull_surface
from hgs_core.points.point_cloud import PointCloud
from hgs_core.render import rasterize
from hgs_core.scene.splats import DynamicSplats, Segment
from hgs_core.train.checkpoint import TrainState
from hgs_core.train.control.round import RoundContext
from hgs_core.train.control.silhouette_steps import SilhouetteSteps
from hgs_core.train.initial_splats import initial_splats
from hgs_core.train.moving_tiles import MovingTiles, tiles_of
from hgs_core.train.schedule import Schedule
from hgs_core.train.training_views import TrainingView
from tests.hgs_core.train.conftest import CONFIG, state_of
from tests.synthetic import synthetic_scene
from tests.walking_body import CAMERAS, body, mask_of

STEPS = dataclasses.replace(CONFIG, moving_steps=8.0)
MASKS = [mask_of(camera, body(0.0)) for camera in CAMERAS]


def views(iteration: int, more: int, size: float) -> Iterator[tuple[TrainingView, MovingTiles]]:
    """Pictures of a grey body before a white room, those of the three cameras in turn."""
    for number in range(1 + more):
        place = number % len(CAMERAS)
        tiles = tiles_of(MASKS[place])
        assert tiles is not None
        moving = torch.from_numpy(MASKS[place][tiles.window])
        target = torch.where(moving, 0.5, 1.0).expand(3, *moving.shape).contiguous()
        yield TrainingView(place, CAMERAS[place], 0.5, target, moving), tiles


def faint_body() -> DynamicSplats[torch.Tensor]:
    """Faint grey splats on the body's hull, and some beside it."""
    grey = [np.full((240, 320, 3), 128, np.uint8)] * 3
    hull = hull_surface(CAMERAS, grey, MASKS, 400)
    xyz = np.concatenate([hull.xyz, hull.xyz[::20] + np.float32(0.12)])
    none, ones = np.zeros(len(xyz), np.float32), np.ones(len(xyz), np.float32)
    points = PointCloud.at_rest(xyz, np.full_like(xyz, 0.5), none, ones, 0.03 * ones)
    return initial_splats(points, Segment(0.0, 1.0, None), 1, opacity=0.2)[1]


def state() -> TrainState:
    return state_of(synthetic_scene()[0].map(torch.clone), faint_body())


def take(state: TrainState, iteration: int) -> None:
    context = SimpleNamespace(
        views=SimpleNamespace(silhouettes=views),
        schedule=Schedule(STEPS, extent=1.0, frames=6),
        iteration=iteration,
        size=0.5,
        statics_learn=True,
        random=lambda purpose: np.random.default_rng((purpose, iteration)),
    )
    SilhouetteSteps(STEPS, throughout=True).apply(state, cast(RoundContext, context))


def coverage(state: TrainState) -> tuple[float, float]:
    """The mean coverage of pixels in the masks, and of those beside them in the same tiles."""
    inside, outside = [], []
    for view, tiles in views(0, 2, 1.0):
        alpha = rasterize(None, state.dynamic, view.camera, view.moment, antialiased=True).alpha[tiles.window]
        assert view.moving is not None
        inside.append(float(alpha[view.moving].mean()))
        outside.append(float(alpha[~view.moving & tiles.drawn()].mean()))
    return float(np.mean(inside)), float(np.mean(outside))


def test_movers_become_opaque_where_masks_say_so_and_nowhere_else() -> None:
    made = state()
    static = made.static.map(torch.clone)
    before = coverage(made)
    for iteration in range(6):
        take(made, iteration)
    inside, outside = coverage(made)
    assert inside > before[0] + 0.1
    assert outside < before[1]
    for (name, was), (_, now) in zip(static.items(), made.static.items(), strict=True):
        assert torch.equal(was, now), name


@pytest.mark.parametrize(("throughout", "last"), [(False, 29), (True, 99)])
def test_iterations_have_them_until_steps_over_the_room_begin(throughout: bool, last: int) -> None:
    control = SilhouetteSteps(dataclasses.replace(CONFIG, iterations=100), throughout)
    assert [iteration for iteration in range(100) if control.due(iteration)] == [*range(last + 1)]


def test_equal_iterations_are_equal() -> None:
    one, two = state(), state()
    for each in (one, two):
        take(each, 3)
    for (name, first), (_, second) in zip(one.dynamic.items(), two.dynamic.items(), strict=True):
        assert torch.equal(first, second), name


def test_what_was_seen_counts_for_density_control() -> None:
    made = state()
    take(made, 0)
    assert not made.statistics.count[: len(made.static)].any()
    assert made.statistics.count[len(made.static) :].any()


def test_without_movers_nothing_is_done() -> None:
    made = state_of(synthetic_scene()[0], faint_body().take(slice(0, 0)))
    take(made, 0)
    assert made.dynamic_optimiser.steps == 0


@pytest.mark.parametrize("moving_steps", [0.0, 3.0])
def test_the_config_says_how_many(moving_steps: float) -> None:
    asked: list[int] = []

    def none(iteration: int, more: int, size: float) -> Iterator[tuple[TrainingView, MovingTiles]]:
        asked.append(more)
        return iter(())

    config = dataclasses.replace(STEPS, moving_steps=moving_steps)
    context = SimpleNamespace(
        views=SimpleNamespace(silhouettes=none),
        iteration=0,
        size=0.5,
        random=np.random.default_rng,
    )
    SilhouetteSteps(config, throughout=True).apply(state(), cast(RoundContext, context))
    assert asked == [round(moving_steps)]
