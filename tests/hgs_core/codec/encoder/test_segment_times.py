from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.codec.encoder.segment_times import frame_interval, shown_segments
from hgs_core.scene import DynamicSplats, HybridScene, Segment, StaticSplats


def scene(*times: tuple[float, float]) -> HybridScene[np.ndarray]:
    return HybridScene(StaticSplats.empty(), tuple(Segment(*time, DynamicSplats.empty()) for time in times))


def test_the_interval_is_that_of_most_frames() -> None:
    assert frame_interval(np.array([0.0, 0.1, 0.2, 0.7])) == pytest.approx(0.1)


def test_a_capture_of_one_frame_has_the_interval_of_30_a_second() -> None:
    assert frame_interval(np.array([5.0])) == pytest.approx(1 / 30)


@pytest.mark.parametrize("times", [np.zeros(0), np.zeros((2, 2)), [0, 0], [0, 2, 1], [0, np.nan], [0, np.inf]])
def test_what_is_no_clock_is_refused(times: object) -> None:
    with pytest.raises(InputError, match="times: are not increasing seconds"):
        frame_interval(np.array(times, float))


def test_a_segment_is_shown_until_the_next_one_starts_and_the_last_to_its_end() -> None:
    first, second = shown_segments(scene((0.0, 0.9), (1.0, 3.0)), 0.1)
    assert [(one.number, one.until) for one in (first, second)] == [(0, 1.0), (1, 3.0)]
    assert first.time.shown_until == pytest.approx(1.0 / 0.9)  # its own time, beyond its end
    assert (second.time.start, second.time.end, second.time.shown_until) == (1.0, 3.0, 1.0)


def test_the_interval_is_told_in_a_segments_own_time() -> None:
    (long,) = shown_segments(scene((1.0, 3.0)), 0.1)
    assert long.frame == pytest.approx(0.05)
    (moment,) = shown_segments(scene((2.0, 2.0)), 0.1)
    assert moment.frame == 1.0


@pytest.mark.parametrize("times", [[], [(1.0, 2.0), (0.0, 1.0)], [(1.0, 0.5)]])
def test_segments_out_of_order_are_refused(times: list[tuple[float, float]]) -> None:
    with pytest.raises(InputError, match=r"scene\.segments: are not in order"):
        shown_segments(scene(*times), 0.1)
