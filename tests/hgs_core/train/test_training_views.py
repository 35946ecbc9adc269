"""The views that rounds of control look at."""

from __future__ import annotations

from pathlib import Path

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


def test_poses_cover_the_segment(views: TrainingViews) -> None:
    poses = list(views.poses(3))
    assert len(poses) == 5
    for _, moments in poses:
        assert moments == pytest.approx([0.0, 0.4, 1.0])
