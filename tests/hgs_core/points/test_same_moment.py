from __future__ import annotations

import numpy as np
import pytest

from hgs_core.capture.capture import Capture
from hgs_core.points.same_moment import same_moments

FRAMES, PERIOD = 6, 0.1


class Clocked:
    """Cameras that took their frames off the clock's ticks by some shares of the period."""

    def __init__(self, *phases: float) -> None:
        self.phases = phases
        self.times = np.arange(FRAMES) * PERIOD

    def moment(self, camera: int, frame: int) -> float:
        return (frame + self.phases[camera]) * PERIOD


def groups(*phases: float, frame: int = 2) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    capture: Capture = Clocked(*phases)  # type: ignore[assignment]
    return [(one.cameras, one.frames) for one in same_moments(capture, range(len(phases)), frame)]


def test_cameras_in_step_are_one_group_at_the_tick() -> None:
    capture: Capture = Clocked(0.0, 0.05, -0.08)  # type: ignore[assignment]
    (one,) = same_moments(capture, (0, 1, 2), 2)
    assert (one.seconds, one.cameras, one.frames) == (0.2, (0, 1, 2), (2, 2, 2))


def test_cameras_half_a_frame_apart_are_two_groups_each_at_its_time() -> None:
    capture: Capture = Clocked(0.0, 0.5, 0.0, 0.5, 0.0, 0.5)  # type: ignore[assignment]
    first, second = same_moments(capture, range(6), 2)
    assert (first.cameras, first.frames, first.seconds) == ((0, 2, 4), (2, 2, 2), pytest.approx(0.2))
    assert (second.cameras, second.frames, second.seconds) == ((1, 3, 5), (2, 2, 2), pytest.approx(0.25))


def test_what_is_nearly_half_a_frame_late_goes_with_what_is_nearly_half_a_frame_early() -> None:
    ((cameras, frames), *_) = groups(0.45, -0.45, 0.48)
    assert sorted(zip(cameras, frames, strict=True)) in ([(0, 2), (1, 3), (2, 2)], [(0, 1), (1, 2), (2, 1)])


def test_at_the_ends_no_frame_is_asked_for_that_there_is_not() -> None:
    for frame in (0, FRAMES - 1):
        for _, frames in groups(0.45, -0.45, 0.48, frame=frame):
            assert all(0 <= own < FRAMES for own in frames)


def test_a_camera_out_of_step_with_all_others_is_left_out() -> None:
    assert groups(0.0, 0.02, -0.03, 0.4) == [((0, 1, 2), (2, 2, 2))]


def test_where_no_three_are_in_step_all_are_one_group() -> None:
    assert groups(0.0, 0.45) == [((0, 1), (2, 2))]
