"""The views that rounds of control look at."""

from __future__ import annotations

import pytest

from hgs_core.train.training_views import TrainingViews


def test_poses_cover_the_segment(views: TrainingViews) -> None:
    poses = list(views.poses(3))
    assert len(poses) == 5
    for _, moments in poses:
        assert moments == pytest.approx([0.0, 0.4, 1.0])
