"""Dynamic splats are born where and when something moves that the scene does not show."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.progress import silent
from hgs_core.capture.open import open_capture
from hgs_core.decompose.masks import motion_masks
from hgs_core.train.control import RoundContext, births
from hgs_core.train.control.births import BirthRound
from hgs_core.train.schedule import Schedule
from hgs_core.train.segment_cuts import cut_into_segments
from hgs_core.train.splat_sets import joined
from hgs_core.train.training_views import TrainingViews
from tests.hgs_core.train.conftest import CONFIG, state_of
from tests.synthetic import EVENT_PLACE, event_splats, synthetic_scene, write_capture
from tests.worker_threads import threads_of

EVENT = range(4, 7)
FRAMES = 10


@pytest.fixture(scope="module")
def context(tmp_path_factory: pytest.TempPathFactory) -> RoundContext:
    """Of a capture in which a ball is there for three of ten frames."""
    path = tmp_path_factory.mktemp("event")
    write_capture(path, cameras=7, frames=FRAMES, event=EVENT)
    capture = open_capture(path)
    (segment,) = cut_into_segments(capture.times, 100)
    masks = motion_masks(capture, range(len(capture.cameras)), progress=silent)
    views = TrainingViews(capture, dict(enumerate(capture.cameras)), CONFIG, segment, masks, 0)
    schedule = Schedule(CONFIG, extent=1.0, frames=FRAMES)
    return RoundContext(0, 0, schedule, views, segment, views.cameras[0], (0, 0), statics_learn=True)


def test_what_appears_is_born_at_its_place_and_time_within_the_room(context: RoundContext) -> None:
    static, dynamic = synthetic_scene()
    state = state_of(static, dynamic)
    BirthRound(CONFIG).apply(state, context)
    born = state.dynamic.take(slice(len(dynamic), None))
    assert 10 < len(born) == state.history.births <= (CONFIG.density.max_dynamic - len(dynamic)) // 2
    distance = np.linalg.norm(born.motion[:, 0].numpy() - EVENT_PLACE, axis=1)
    assert np.quantile(distance, 0.9) < 0.35  # the ball's radius is 0.25
    frames = np.rint(born.time_centers.numpy() * (FRAMES - 1)).astype(int)
    assert set(frames) == set(EVENT)
    assert len(state.dynamic_optimiser.moments) == len(state.dynamic)
    assert len(state.statistics.count) == len(state.static) + len(state.dynamic)


def test_where_the_scene_has_it_already_nothing_is_born(context: RoundContext) -> None:
    static, dynamic = synthetic_scene()
    state = state_of(joined(static, event_splats()), dynamic)
    BirthRound(CONFIG).apply(state, context)
    places = state.dynamic.motion[len(dynamic) :, 0].numpy()
    frames = np.rint(state.dynamic.time_centers[len(dynamic) :].numpy() * (FRAMES - 1)).astype(int)
    assert not ((np.linalg.norm(places - EVENT_PLACE, axis=1) < 0.35) & np.isin(frames, EVENT)).any()


def test_cameras_are_looked_at_on_all_cores_to_the_same_bits(
    context: RoundContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    threads = threads_of(monkeypatch, births, "picture_error")
    born = []
    for count in ("1", "4"):
        monkeypatch.setenv("HGS_THREADS", count)
        state = state_of(*synthetic_scene())
        BirthRound(CONFIG).apply(state, context)
        born.append(state.dynamic)
    for name, values in born[0].items():
        np.testing.assert_array_equal(values, getattr(born[1], name), err_msg=name)
    assert threads
    assert "MainThread" not in threads
