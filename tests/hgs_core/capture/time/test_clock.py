"""One clock for cameras with their own time stamps."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.time.clock import CameraTime, common_clock, mean_rate


def camera(name: str, count: int, *, rate: float = 30.0, start: float = 0.0, tolerance: float = 0.0) -> CameraTime:
    return CameraTime(name, start + np.arange(count) / rate, rate, tolerance)


def test_cameras_in_step_show_all_their_frames() -> None:
    clock = common_clock("x", [camera("a", 5), camera("b", 5)])
    np.testing.assert_allclose(clock.times, np.arange(5) / 30)
    assert clock.frames.tolist() == [list(range(5))] * 2
    np.testing.assert_array_equal(clock.moments, [clock.times] * 2)
    assert clock.notes == ()


def test_a_camera_that_starts_later_is_matched_by_time() -> None:
    clock = common_clock("x", [camera("a", 10), camera("b", 8, start=3 / 30)])
    assert clock.frames.tolist() == [[3, 4, 5, 6, 7, 8, 9], [0, 1, 2, 3, 4, 5, 6]]
    assert clock.times[0] == 0.0
    np.testing.assert_allclose(clock.moments, [clock.times] * 2)
    assert clock.notes == (
        "the capture begins with b: 3 moments of other cameras left out",
        "the capture ends with a: 1 moment of other cameras left out",
    )


def test_half_a_frame_late_keeps_its_own_time() -> None:
    clock = common_clock("x", [camera("a", 5), camera("b", 5, start=0.5 / 30)])
    assert clock.frames.tolist() == [list(range(5))] * 2
    np.testing.assert_allclose(clock.moments[1] - clock.times, 0.5 / 30)
    assert clock.notes == ("frames of b are up to 16.7 ms off the clock, and trained at their times",)


def test_what_stamps_may_err_is_not_late() -> None:
    clock = common_clock("x", [camera("a", 5), camera("b", 5, start=0.0009, tolerance=0.001)])
    np.testing.assert_array_equal(clock.moments[1], clock.times)


def test_29_97_among_30_drifts_until_a_frame_is_left_out() -> None:
    clock = common_clock("x", [camera("a", 1200), camera("b", 1200), camera("c", 1200, rate=30000 / 1001)])
    assert len(clock.times) == 1199  # one moment after 33 s has no nearest frame of c
    assert np.abs(clock.moments[2] - clock.times).max() <= 0.5 / 30 + 1e-9
    np.testing.assert_allclose(clock.moments[2], np.arange(1200)[clock.frames[2]] * 1001 / 30000)
    assert "these have others: c 29.97" in " ".join(clock.notes)


def test_a_dropped_frame_leaves_out_its_moment_alone() -> None:
    stamps = np.delete(np.arange(6), 2) / 30
    clock = common_clock("x", [camera("a", 6), CameraTime("b", stamps, 30.0)])
    np.testing.assert_allclose(clock.times, stamps)
    assert clock.frames.tolist() == [[0, 1, 3, 4, 5], [0, 1, 2, 3, 4]]
    assert clock.notes == ("1 moment of 6 left out, at which b has no frame",)


def test_of_two_frames_at_a_moment_the_nearer_is_shown() -> None:
    stamps = np.array([0.0, 0.012, 0.03, 0.07])  # 33 ms periods: 12 and 30 ms are nearest to the second
    clock = common_clock("x", [camera("a", 3), camera("b", 3), CameraTime("c", stamps, 43.0)])
    assert clock.frames[2].tolist() == [0, 2, 3]
    assert any("c has 1 frame too many" in note for note in clock.notes)


def test_the_clock_ticks_at_the_rate_that_most_cameras_have() -> None:
    clock = common_clock("x", [camera("a", 10, rate=60), camera("b", 5), camera("c", 5)])
    np.testing.assert_allclose(np.diff(clock.times), 1 / 30)
    assert clock.frames[0].tolist() == [0, 2, 4, 6, 8]


def test_cameras_without_a_common_moment_are_refused() -> None:
    with pytest.raises(InputError, match=r"no moment in common: a 0\.00 to 0\.13 s, b 9\.00 to 9\.13 s; .*sync\.json"):
        common_clock("x", [camera("a", 5), camera("b", 5, start=9.0)])


def test_stamps_that_do_not_increase_are_refused() -> None:
    with pytest.raises(InputError, match="the times of camera b do not increase"):
        common_clock("x", [camera("a", 3), CameraTime("b", np.array([0.0, 0.1, 0.1]), 30.0)])


@pytest.mark.parametrize("rate", [24.0, 30.0, 59.94, 120.0])
def test_a_rate_is_that_of_all_stamps_however_they_are_rounded(rate: float) -> None:
    """Steps of 33 and 34 ms are 30 per second, not 30.3; a missing frame is no slower one."""
    stamps = np.round(np.arange(300) / rate, 3)
    assert mean_rate(stamps) == pytest.approx(rate, rel=1e-3)
    assert mean_rate(np.delete(stamps, [7, 8, 100])) == pytest.approx(rate, rel=1e-3)
