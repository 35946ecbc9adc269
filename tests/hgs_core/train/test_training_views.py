"""The views that rounds of control look at."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hgs_core.capture.open import open_capture
from hgs_core.train.segment_cuts import cut_into_segments
from hgs_core.train.time_shifts import TimeShifts
from hgs_core.train.train_config import TrainConfig
from hgs_core.train.training_views import TrainingViews
from tests.synthetic import write_capture


def test_a_view_is_of_the_moment_when_its_camera_took_it(tmp_path: Path) -> None:
    write_capture(tmp_path, frames=5, late={"1": 0.5})
    capture = open_capture(tmp_path)
    segment = cut_into_segments(capture.times, 100)[0]
    config = TrainConfig(colour_correction=False, iterations=400)
    views = TrainingViews(capture, dict(enumerate(capture.cameras)), config, segment, None, 0)
    found: dict[int, set[float]] = {}
    for iteration in range(400):
        view = views.of_iteration(iteration, 1.0)
        found.setdefault(view.place, set()).add(round(view.moment, 6))
    assert sorted(found[0]) == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert sorted(found[1]) == [0.125, 0.375, 0.625, 0.875, 1.125]


def test_a_learned_clock_is_added_to_that_of_the_capture(views: TrainingViews) -> None:
    before = views.of_iteration(3, 1.0)
    views.time_shifts = TimeShifts(len(views.cameras))
    views.time_shifts.seconds[before.place] = 0.25
    late = views.of_iteration(3, 1.0)
    views.time_shifts = None
    clock = views._segment.clock
    assert late.moment - before.moment == pytest.approx(0.25 / (clock.end - clock.start))


def test_neighbouring_cameras_cover_the_segment_in_turns(views: TrainingViews) -> None:
    poses = [moments for _, moments in views.poses(3)]
    assert poses == [pytest.approx([0.0, 1.0]), pytest.approx([0.4])] * 2 + [pytest.approx([0.0, 1.0])]


def test_every_camera_sees_the_only_moment(views: TrainingViews) -> None:
    assert [len(moments) for _, moments in views.poses(1)] == [1] * 5


@pytest.mark.parametrize("size", [1.0, 0.5])
def test_rounds_look_at_pictures_of_the_size_that_is_trained(views: TrainingViews, size: float) -> None:
    whole = views.cameras[0]
    sides = round(whole.height * size), round(whole.width * size)
    for instant in views.instants(2, size, np.random.default_rng(0)):
        for camera, picture, moving in zip(instant.cameras, instant.pictures, instant.moving, strict=True):
            assert (camera.height, camera.width) == picture.shape[:2] == moving.shape == sides
    for camera_views in views.everywhere(0, size):
        for view in camera_views:
            assert view.moving is not None
            assert (view.camera.height, view.camera.width) == view.target.shape[1:] == view.moving.shape == sides
