"""Cutting a capture into segments."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.points.point_cloud import PointCloud
from hgs_core.train.segment_cuts import cut_into_segments


@given(frames=st.integers(1, 700), longest=st.integers(2, 200))
def test_segments_are_few_even_and_cover_every_frame_once(frames: int, longest: int) -> None:
    segments = cut_into_segments(np.arange(frames) / 30, longest)
    lengths = [segment.frames for segment in segments]
    assert len(lengths) == -(-frames // longest)
    assert max(lengths) - min(lengths) <= 1
    covered = [segment.first + i for segment in segments for i in range(segment.frames)]
    assert covered == list(range(frames))


def test_a_segment_ends_where_the_next_one_starts() -> None:
    times = np.arange(10) / 10
    first, second = cut_into_segments(times, 5)
    assert (first.clock.start, first.clock.end) == (0.0, 0.5)
    assert (second.clock.start, second.clock.end) == (0.5, 0.9)


@given(frames=st.integers(1, 700), longest=st.integers(2, 200), every=st.integers(1, 100))
def test_points_are_taken_at_both_ends_of_a_segment_and_evenly_between(frames: int, longest: int, every: int) -> None:
    times = np.arange(frames) / 30
    for segment in cut_into_segments(times, longest):
        sampled = segment.sampled(every)
        assert (times[sampled[0]], times[sampled[-1]]) == (segment.clock.start, segment.clock.end)
        gaps = np.diff(sampled)
        assert len(gaps) == 0 or (gaps.max() <= every and gaps.max() - gaps.min() <= 1)


def test_a_single_moment_is_a_segment_of_no_length() -> None:
    (segment,) = cut_into_segments(np.zeros(1), 50)
    assert (segment.frames, segment.clock.start, segment.clock.end) == (1, 0.0, 0.0)


def test_dynamic_points_belong_to_their_moments_and_static_ones_to_all() -> None:
    cloud = PointCloud.at_rest(
        np.zeros((4, 3), np.float32),
        np.zeros((4, 3), np.float32),
        np.array([0.0, 0.1, 0.8, 0.0], np.float32),
        np.array([1, 1, 1, 0], np.float32),
        np.ones(4, np.float32),
    )
    first, second = cut_into_segments(np.arange(10) / 10, 5)
    assert first.points(cloud).times.tolist() == pytest.approx([0.0, 0.1, 0.0])
    assert second.points(cloud).times.tolist() == pytest.approx([0.8, 0.0])
