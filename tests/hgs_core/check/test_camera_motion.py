from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.camera_motion import camera_shift
from hgs_core.points.features import Features

COUNT = 60


def features(xy: np.ndarray) -> Features:
    descriptors = np.random.default_rng(1).integers(0, 100, (COUNT, 128)).astype(np.float64)
    descriptors *= 512 / np.linalg.norm(descriptors, axis=1, keepdims=True)
    return Features(xy, descriptors.round().clip(0, 255).astype(np.float32))


@pytest.fixture
def places() -> np.ndarray:
    return np.random.default_rng(2).uniform(0, 400, (COUNT, 2))


def test_a_camera_whose_picture_shifts_as_a_whole_moves(places: np.ndarray) -> None:
    moved = places @ np.array([[1.0, 0.02], [-0.02, 1.0]]) + (12.0, -3.0)
    shift = camera_shift(features(places), features(moved))
    assert shift is not None
    assert 5 < shift < 30


def test_a_camera_stands_still_while_two_thirds_of_what_it_sees_move(places: np.ndarray) -> None:
    moved = places + np.where(np.arange(COUNT) % 3 == 0, 0.0, 1.0)[:, None] * (20.0, 5.0)
    assert camera_shift(features(places), features(moved)) is None


def test_things_that_move_each_for_itself_do_not_move_the_camera(places: np.ndarray) -> None:
    moved = places + np.random.default_rng(3).uniform(-40, 40, (COUNT, 2))
    assert camera_shift(features(places), features(moved)) is None
