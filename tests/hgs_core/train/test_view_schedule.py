"""Which view each iteration sees."""

from __future__ import annotations

from collections import Counter

import pytest

from hgs_core.train.view_schedule import ViewSchedule


def test_a_capture_that_fits_is_drawn_from_as_a_whole() -> None:
    schedule = ViewSchedule.fitting((0, 2, 3), 10, frame_bytes=100, memory=10**6, iterations=3000, seed=1)
    seen = Counter(schedule.view(iteration) for iteration in range(3000))
    assert set(seen) == {(camera, frame) for camera in (0, 2, 3) for frame in range(10)}
    assert max(seen.values()) < 2 * 100


@pytest.mark.parametrize("frames", [10, 11])
def test_a_long_capture_is_visited_in_blocks_that_fit(frames: int) -> None:
    schedule = ViewSchedule.fitting((0, 1), frames, frame_bytes=100, memory=800, iterations=1200, seed=1)
    assert (schedule.blocks, schedule.stay) == (3, 20)
    visited: set[int] = set()
    for start in range(0, 60, 20):
        block = {schedule.view(iteration)[1] for iteration in range(start, start + 20)}
        assert max(block) - min(block) < 4
        visited |= block
    assert visited == set(range(frames))


def test_all_frames_are_looked_at_about_as_often_until_the_end() -> None:
    schedule = ViewSchedule.fitting((0, 1), 15, frame_bytes=100, memory=2200, iterations=6000, seed=1)
    for first in (0, 5400):
        seen = Counter(schedule.view(iteration)[1] for iteration in range(first, first + 600))
        assert len(seen) == 15
        assert max(seen.values()) < 2 * 40


def test_memory_for_less_than_one_frame_still_works() -> None:
    schedule = ViewSchedule.fitting((5,), 3, frame_bytes=1000, memory=10, iterations=20, seed=0)
    assert {schedule.view(iteration)[0] for iteration in range(20)} == {5}


def test_views_depend_on_seed_and_iteration_alone() -> None:
    one, two = (ViewSchedule.fitting((0, 1, 2), 30, 10, 300, 1000, seed=7) for _ in range(2))
    assert [one.view(c) for c in (90, 3, 50)] == [two.view(c) for c in (90, 3, 50)]
