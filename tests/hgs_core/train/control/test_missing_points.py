"""New splats where moving pixels are wrong."""

from __future__ import annotations

import numpy as np
import torch

from hgs_core.points.point_cloud import PointCloud
from hgs_core.points.sweep import depth_ranges
from hgs_core.scene.splats import StaticSplats
from hgs_core.train.control.missing_points import MissingPoints, chosen_points, find_missing_points, picture_error
from tests.balls import BALL, CAMERAS, RADIUS, balls, pictures, truths


def births(shown: StaticSplats[torch.Tensor] | None, most: int = 100) -> np.ndarray:
    """Points born where a ball is missing in the picture."""
    seen = truths(balls(BALL))
    moving = [(np.abs(picture.astype(int) - 51) > 10).any(2) for picture in seen]
    errors = [picture_error(p, truth) for p, truth in zip(pictures(shown), seen, strict=True)]
    known = np.random.default_rng(1).uniform(-1, 1, (200, 3))
    found = find_missing_points(CAMERAS, seen, moving, errors, depth_ranges(CAMERAS, known))
    cloud = chosen_points([found], most, np.random.default_rng(2))
    assert (cloud.spacing > 0).all()
    return cloud.xyz


def test_a_missing_ball_is_born_where_it_is() -> None:
    xyz = births(None)
    assert len(xyz) > 20
    distance = np.linalg.norm(xyz - BALL, axis=1)
    assert np.median(np.abs(distance - RADIUS)) < 0.08
    assert (distance < 0.5).mean() > 0.9


def test_nothing_is_born_where_the_picture_is_right() -> None:
    assert len(births(balls(BALL))) == 0


def test_no_more_are_born_than_there_is_room_for() -> None:
    assert len(births(None, most=7)) == 7
    assert len(births(None, most=0)) == 0


def test_the_error_of_a_picture_is_in_levels() -> None:
    truth = np.full((6, 6, 3), 100, np.uint8)
    error = picture_error(torch.full((3, 6, 6), 120 / 255), truth)
    assert error[2:-2, 2:-2].tolist() == [[20.0, 20.0]] * 2


def test_the_moment_that_lacks_most_gets_most() -> None:
    def lacking(time: float, urgency: float) -> MissingPoints:
        places = np.zeros((100, 3), np.float32)
        cloud = PointCloud.at_rest(places, places, np.full(100, time, np.float32), places[:, 0], places[:, 0])
        return MissingPoints(cloud, np.full(100, urgency))

    chosen = chosen_points([lacking(0.0, 100.0), lacking(1.0, 900.0)], 60, np.random.default_rng(0))
    assert len(chosen) == 60
    assert 45 < int((chosen.times == 1.0).sum()) < 60  # 54 expected, with replacement
