"""Dynamic splats in and out of the hull of a ball that moving masks show."""

from __future__ import annotations

import math

import numpy as np
import torch

from hgs_core.scene.splats import DynamicSplats
from hgs_core.train.control.hull import ever_inside, outside_moving_hull
from tests.balls import BALL, CAMERAS, balls, truths

FRAMES = 11
BRIEF = math.log(math.log(2) / 0.1**2)  # log precision of a life of a tenth of the segment
LONG = math.log(math.log(2) / 0.3**2)
AWAY = BALL + np.array([-0.9, 0.3, 0.4])


def splat(place: np.ndarray, velocity: float = 0.0, centre: float = 0.5, log_precision: float = BRIEF) -> bool:
    """Whether a splat that starts at `place`, at a velocity across the pictures, has strayed."""
    moving = [(np.abs(picture.astype(int) - 51) > 10).any(2) for picture in truths(balls(BALL))]
    motion = torch.zeros(1, 4, 3)
    motion[0, 0], motion[0, 1, 1] = torch.tensor(place), velocity
    one = DynamicSplats(
        motion,
        torch.zeros(1, 2, 4),
        torch.zeros(1, 3),
        torch.zeros(1),
        torch.tensor([centre]),
        torch.tensor([log_precision]),
        torch.zeros(1, 3),
    )
    return bool(outside_moving_hull(one, CAMERAS, FRAMES, lambda frame: moving)[0])


def test_what_is_in_the_hull_stays() -> None:
    assert not splat(BALL)


def test_what_hangs_elsewhere_for_a_while_has_strayed() -> None:
    assert splat(AWAY)


def test_what_flies_out_has_strayed() -> None:
    assert splat(BALL, velocity=20.0)
    assert not splat(BALL, velocity=0.5)


def test_what_lives_long_may_be_elsewhere() -> None:
    assert not splat(AWAY, log_precision=LONG)


def test_a_place_is_inside_if_something_moves_there_at_one_of_the_moments() -> None:
    moving = [(np.abs(picture.astype(int) - 51) > 10).any(2) for picture in truths(balls(BALL))]
    still = [np.zeros_like(mask) for mask in moving]
    places = np.stack([BALL, AWAY]).astype(np.float32)
    asked: list[int] = []

    def late(frame: int) -> list[np.ndarray]:
        asked.append(frame)
        return moving if frame == FRAMES - 1 else still

    assert ever_inside(places, CAMERAS, FRAMES, late).tolist() == [True, False]
    assert asked == list(range(FRAMES))
    assert not ever_inside(places, CAMERAS, FRAMES, lambda frame: still).any()


def test_what_lives_outside_of_the_segment_is_not_looked_at() -> None:
    assert not splat(AWAY, centre=3.0)
