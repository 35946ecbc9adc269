"""Displacements of points against those that the pictures were made with."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.points.scene_flow import scene_flow
from tests.balls import BALL, CAMERAS, RADIUS, balls, truths

PIXEL = 3.0 / CAMERAS[0].fx  # world units at the balls


def flow(step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points on a ball that moves by `step`, and the displacements found for them."""
    now, later = truths(balls(BALL)), truths(balls(BALL + step))
    moving = [(np.abs(picture.astype(int) - 51) > 10).any(2) for picture in now]
    outwards = np.random.default_rng(0).normal(size=(150, 3))
    outwards[:, 2] = -np.abs(outwards[:, 2])  # the cameras are on that side
    xyz = BALL + RADIUS * outwards / np.linalg.norm(outwards, axis=1)[:, None]
    return xyz, scene_flow(CAMERAS, now, later, moving, xyz)


@pytest.mark.parametrize("pixels", [(3, 0, 0), (0, -8, 0), (10, 9, 0), (-6, 5, 8)])
def test_a_ball_is_followed(pixels: tuple[float, float, float]) -> None:
    step = PIXEL * np.array(pixels)
    _, found = flow(step)
    assert np.median(np.linalg.norm(found - step, axis=1)) < 1.5 * PIXEL


def test_what_is_at_rest_has_no_flow() -> None:
    assert not flow(np.zeros(3))[1].any()


def test_what_nobody_sees_move_has_no_flow() -> None:
    still = [np.zeros((96, 128), np.bool_)] * len(CAMERAS)
    now, later = truths(balls(BALL)), truths(balls(BALL + 0.1))
    assert not scene_flow(CAMERAS, now, later, still, BALL[None]).any()


def test_there_may_be_no_points() -> None:
    now = truths(balls(BALL))
    assert scene_flow(CAMERAS, now, now, [np.ones((96, 128), np.bool_)] * 6, np.zeros((0, 3))).shape == (0, 3)
