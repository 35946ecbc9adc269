"""Training a scene as it decodes, on a tiny capture of the very scene."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import torch

from hgs_core.base.progress import StageStopped
from hgs_core.capture.open import open_capture
from hgs_core.codec.encoder.decoded_preview import quantised_scene
from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.utility import Utility
from hgs_core.fit.coarseness import fit
from hgs_core.fit.encoding_loss import Loss
from hgs_core.fit.encoding_views import EncodeViews
from hgs_core.fit.fine_tune import FineTune
from hgs_core.fit.fit_config import BUDGETS
from hgs_core.fit.measured_utility import measure_utility
from hgs_core.scene import DynamicSplats, HybridScene, Segment
from hgs_core.scene.splats import joined
from hgs_core.train.checkpoint import fresh_state
from hgs_core.train.schedule import share_alive
from hgs_core.train.targets import target_picture
from hgs_core.train.train_config import TrainConfig
from tests.synthetic import synthetic_scene, write_capture

COARSE = EncodeSettings(coarseness=3.0, prune=0, prune_dynamic=0)  # nothing stands in for so few splats
CONFIG = TrainConfig(antialiased=False)
Given = tuple[HybridScene[np.ndarray], EncodeViews, Utility]


@pytest.fixture(scope="module")
def given(tmp_path_factory: pytest.TempPathFactory) -> Given:
    path = tmp_path_factory.mktemp("capture")
    cameras = write_capture(path)
    static, dynamic = synthetic_scene()
    capture = open_capture(path)
    scene = HybridScene(static, (Segment(0.0, 5 / 30, dynamic),)).map(lambda tensor: tensor.numpy())
    trained = {i: camera for i, camera in enumerate(cameras) if camera.name != "2"}
    views = EncodeViews(
        "",
        tuple(cameras),
        trained,
        capture.times,
        lambda camera, frame: target_picture(capture, camera, frame, cameras[camera]),
        capture,
    )
    return scene, views, measure_utility(scene, list(trained.values()), capture.times)


def test_it_wins_back_what_quantisation_costs(given: Given) -> None:
    scene, views, utility = given
    loss = Loss(scene, views, views.trained)

    def lost(scene: HybridScene[np.ndarray], utility: Utility) -> float:
        return loss.of(quantised_scene(scene, views.cameras, views.times, utility, COARSE).decoded).whole

    before = lost(scene, utility)
    tune = FineTune(scene, utility, views, CONFIG, 0, ())
    done: list[int] = []
    tune.run(COARSE, range(120), done.append)
    assert done == list(range(1, 121))
    assert before > 1
    assert lost(tune.scene, tune.utility) < 0.7 * before


def test_equal_arguments_give_equal_scenes_and_leave_the_given_one_alone(given: Given) -> None:
    scene, views, utility = given
    copy = scene.map(np.copy)
    tuned = []
    for _ in range(2):
        tune = FineTune(scene, utility, views, CONFIG, 0, ())
        tune.run(COARSE, range(60), lambda done: None)
        tuned.append(tune)
    first, second = tuned
    for one, other in ((first.scene, second.scene), (scene, copy)):
        for (_, a), (_, b) in zip(one.static.items(), other.static.items(), strict=True):
            np.testing.assert_array_equal(a, b)
        for (_, a), (_, b) in zip(one.segments[0].dynamic.items(), other.segments[0].dynamic.items(), strict=True):
            np.testing.assert_array_equal(a, b)
    assert len(first.scene.static) == len(first.utility.static.shown) <= len(scene.static)


def test_views_are_of_the_moments_that_training_learned(given: Given) -> None:
    scene, views, utility = given
    moved = []
    for seconds in (0.0, 0.02):
        splats = (scene.static.map(torch.from_numpy), scene.segments[0].dynamic.map(torch.from_numpy))
        state = fresh_state(*splats, len(views.trained), CONFIG)
        assert state.time_shifts is not None
        state.time_shifts.seconds[:] = seconds
        tune = FineTune(scene, utility, views, CONFIG, 0, [state])
        tune.run(COARSE, range(3), lambda _: None)  # the first step has one size for any gradient
        moved.append(tune.scene.segments[0].dynamic.time_centers)
    assert not np.array_equal(*moved)


def test_a_budget_is_kept_with_coarser_codes_than_without(given: Given) -> None:
    scene, views, utility = given
    plain = fit(scene, views, utility, "low", CONFIG)
    tuned = fit(scene, views, utility, "low", CONFIG, iterations=200)
    assert tuned.loss.most <= BUDGETS["low"]
    assert tuned.settings.coarseness > plain.settings.coarseness


def test_it_can_be_stopped(given: Given) -> None:
    scene, views, utility = given

    def stop(done: int) -> None:
        if done == 3:
            raise StageStopped

    with pytest.raises(StageStopped):
        fit(scene, views, utility, "low", CONFIG, iterations=10, trained=stop)


def test_it_takes_smaller_steps_of_what_lives_shortly(given: Given) -> None:
    scene, views, _ = given
    (segment,) = scene.segments
    precisions = np.array([-8.0, 2.5, 3.0], np.float32)
    brief = HybridScene(
        scene.static,
        (dataclasses.replace(segment, dynamic=dataclasses.replace(segment.dynamic, time_log_precisions=precisions)),),
    )
    utility = measure_utility(brief, list(views.trained.values()), views.capture.times)
    moved = []
    for by_life in (True, False):
        tune = FineTune(brief, utility, views, dataclasses.replace(CONFIG, steps_by_life=by_life), 0, ())
        tune.run(COARSE, range(1), lambda done: None)
        moved.append(tune.scene)
    ours, equal = (after.segments[0].dynamic.opacity_logits - segment.dynamic.opacity_logits for after in moved)
    factors = share_alive(brief.segments[0].dynamic.map(torch.from_numpy)).sqrt().numpy()
    assert equal.all()
    # It is taken of the decoded lives, which differ a little from the exact ones.
    np.testing.assert_allclose(ours / equal, factors, rtol=0.05)
    assert factors[2] < 0.85
    for (_, one), (_, other) in zip(moved[0].static.items(), moved[1].static.items(), strict=True):
        np.testing.assert_array_equal(one, other)


def test_motion_of_the_fifth_order_learns_in_all_its_coefficients_whatever_orders_are_coded(given: Given) -> None:
    scene, views, utility = given
    (segment,) = scene.segments
    fifth = dataclasses.replace(segment, dynamic=joined([DynamicSplats.empty(6), segment.dynamic]))
    tune = FineTune(
        HybridScene(scene.static, (fifth,)), utility, views, dataclasses.replace(CONFIG, motion_order=5), 0, ()
    )
    tune.run(COARSE, range(3), lambda done: None)
    assert tune.scene.segments[0].dynamic.motion.shape[1:] == (6, 3)
    assert tune.scene.segments[0].dynamic.motion[:, 5].any()
