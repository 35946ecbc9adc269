"""Rounds of control over a whole training state."""

from __future__ import annotations

import pytest
import torch

from hgs_core.base.progress import silent
from hgs_core.capture.capture import Capture
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import MotionMasks, motion_masks
from hgs_core.scene.splats import DynamicSplats, StaticSplats
from hgs_core.train.checkpoint import TrainState, fresh_state
from hgs_core.train.config import TrainConfig
from hgs_core.train.control import control_births, control_contributions, control_infill, control_labels
from hgs_core.train.density import joined
from hgs_core.train.schedule import Schedule
from hgs_core.train.segments import CaptureSegment, cut_into_segments
from hgs_core.train.training_views import TrainingViews
from tests.synthetic import synthetic_scene, write_capture

CONFIG = TrainConfig(max_dynamic=100, colour_correction=False)


def schedule_of(config: TrainConfig = CONFIG) -> Schedule:
    return Schedule(config, extent=1.0, frames=6)


@pytest.fixture(scope="module")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Capture:
    path = tmp_path_factory.mktemp("capture")
    write_capture(path)
    return open_capture(path)


@pytest.fixture(scope="module")
def masks(capture: Capture) -> MotionMasks:
    return motion_masks(capture, range(len(capture.cameras)), progress=silent)


@pytest.fixture(scope="module")
def segment(capture: Capture) -> CaptureSegment:
    return cut_into_segments(capture.times, 100)[0]


@pytest.fixture
def views(capture: Capture, masks: MotionMasks, segment: CaptureSegment) -> TrainingViews:
    return TrainingViews(capture, capture.cameras, CONFIG, segment, masks)


def state_of(static: StaticSplats[torch.Tensor], dynamic: DynamicSplats[torch.Tensor]) -> TrainState:
    return fresh_state(static, dynamic, 5, CONFIG)


def check_consistent(state: TrainState) -> None:
    """Optimisers and statistics have a row per splat."""
    assert len(state.static_adam.first) == len(state.static)
    assert len(state.dynamic_adam.second) == len(state.dynamic)
    assert len(state.statistics.count) == len(state.static) + len(state.dynamic)


def test_splats_that_no_view_needs_are_removed_and_the_others_kept(
    views: TrainingViews, segment: CaptureSegment
) -> None:
    static, dynamic = synthetic_scene()
    hidden = static.take(slice(0, 5))
    behind = StaticSplats(hidden.means + 100, hidden.log_scales, hidden.quats, hidden.opacity_logits, hidden.rgb)
    state = state_of(joined(static, behind), dynamic)
    control_contributions(state, schedule_of(), views, segment, statics_learn=True)
    assert len(static) * 0.9 < len(state.static) <= len(static)
    assert float(state.static.means.abs().max()) < 50
    assert len(state.dynamic) == len(dynamic)
    assert state.history.pruned == len(static) + 5 - len(state.static)
    check_consistent(state)


def test_statics_that_do_not_learn_are_not_pruned(views: TrainingViews, segment: CaptureSegment) -> None:
    static, dynamic = synthetic_scene()
    far = StaticSplats(static.means + 100, static.log_scales, static.quats, static.opacity_logits, static.rgb)
    state = state_of(far, dynamic)
    control_contributions(state, schedule_of(), views, segment, statics_learn=False)
    assert len(state.static) == len(far)
    check_consistent(state)


def test_births_stay_within_the_room_and_stand_where_something_moves(
    views: TrainingViews, segment: CaptureSegment
) -> None:
    static, dynamic = synthetic_scene()
    state = state_of(static, dynamic.take(slice(0, 0)))
    control_births(state, schedule_of(), views, segment, cycle=0)
    assert state.history.births == len(state.dynamic) <= CONFIG.max_dynamic // 2
    check_consistent(state)


def test_labels_move_splats_between_the_sets(views: TrainingViews) -> None:
    static, dynamic = synthetic_scene()
    still = DynamicSplats(
        *(array.clone() for _, array in dynamic.items())
    )  # the first one stands still, and is visible all the time
    still.motion[0, 1:] = 0
    still.time_log_precisions[0] = -9.0
    state = state_of(static, still)
    control_labels(state, schedule_of(TrainConfig(max_dynamic=100, restless_error=0.0)), views, cycle=0)
    assert (len(state.static), len(state.dynamic)) == (len(static) + 1, len(dynamic) - 1)
    torch.testing.assert_close(state.static.means[-1], still.motion[0, 0])
    assert state.history.labels_changed == {"to_static": 1, "to_dynamic": 0}
    check_consistent(state)


def test_a_static_splat_in_the_way_of_motion_becomes_dynamic(capture: Capture, views: TrainingViews) -> None:
    static, dynamic = synthetic_scene()
    state = state_of(static, dynamic.take(slice(0, 0)))  # what moves is missing: statics must stand in
    schedule = schedule_of(TrainConfig(max_dynamic=100, restless_error=0.005))
    control_labels(state, schedule, views, cycle=0)
    changed = state.history.labels_changed["to_dynamic"]
    assert 0 < changed <= 0.02 * len(static)
    assert len(state.dynamic) == 2 * changed
    assert len(state.static) == len(static) - changed
    check_consistent(state)


def test_poses_cover_the_segment(views: TrainingViews) -> None:
    poses = list(views.poses(3))
    assert len(poses) == 5
    for _, moments in poses:
        assert moments == pytest.approx([0.0, 0.4, 1.0])


def test_statics_are_added_where_still_pixels_are_wrong_within_the_budget(
    views: TrainingViews, segment: CaptureSegment
) -> None:
    static, dynamic = synthetic_scene()
    state = state_of(static.take(slice(0, 60)), dynamic)
    schedule = schedule_of(TrainConfig(infill=0.1, max_static=100, colour_correction=False))
    control_infill(state, schedule, views, segment, cycle=0)
    assert 60 < len(state.static) <= 70
    assert state.history.infilled == len(state.static) - 60
    check_consistent(state)
