"""Time codes with and without dropped frames, and those that no clock set."""

from __future__ import annotations

import pytest

from hgs_core.capture.time.timecodes import CodedStart, starts_by_timecode, timecode_seconds

NTSC = 30000 / 1001


def starts(*codes: str, rate: float = NTSC, length: float = 0.8) -> list[CodedStart]:
    return [CodedStart(f"cam{number}", code, rate, length) for number, code in enumerate(codes)]


@pytest.mark.parametrize(
    ("code", "rate", "seconds"),
    [
        ("00:00:01:15", 30.0, 1.5),
        ("01:00:00;00", NTSC, 107892 / NTSC),  # SMPTE 12M: an hour of drop-frame code is 107,892 frames
        ("01:00:00.00", NTSC, 107892 / NTSC),
        ("01:00:00,00", NTSC, 107892 / NTSC),
        ("00:01:00;02", NTSC, 1800 / NTSC),
        ("00:10:00;00", 60000 / 1001, 35964 * 1001 / 60000),
        ("01:00:00;00", 25.0, 3600.0),  # codes of 25 frames drop none
        ("00:00:01:119", 120.0, 1 + 119 / 120),
        ("01:00:00:00", 24000 / 1001, 3603.6),
        ("00:61:00:00", 30.0, None),
        ("noon", 30.0, None),
    ],
)
def test_seconds_of_a_time_code(code: str, rate: float, seconds: float | None) -> None:
    assert timecode_seconds(code, rate) == (None if seconds is None else pytest.approx(seconds))


def test_colons_among_semicolons_are_read_alike_where_nothing_else_fits() -> None:
    found = starts_by_timecode(starts("14:30:49;10", "14:30:49:11", "14:30:49;10"))
    assert [second - found.seconds[0] for second in found.seconds] == pytest.approx([0, 1 / NTSC, 0])
    assert found.notes == ("the time codes of cam1 have a colon, others a semicolon: all are read as dropping frames",)


def test_colons_among_semicolons_count_as_written_where_they_fit() -> None:
    found = starts_by_timecode(starts("00:00:10;10", "00:00:10:20"))
    assert found.seconds[1] - found.seconds[0] == pytest.approx(10 / NTSC)
    assert found.notes == ()


@pytest.mark.parametrize("unset", ["01:00:00:00", "00:00:00:00", "00:00:00;00"])
def test_a_clock_that_was_never_set_is_named(unset: str) -> None:
    found = starts_by_timecode(starts("10:15:00:00", unset, "10:15:00:02", rate=30.0))
    assert [name for name in ("cam0", "cam1", "cam2") if name in found.problem] == ["cam1"]
    assert f"({unset}, " in found.problem
    assert "before most, as of a recorder whose clock was never set" in found.problem


def test_a_camera_of_another_time_is_named_without_a_guess_at_its_clock() -> None:
    found = starts_by_timecode(starts("10:15:00:00", "10:15:00:01", "11:15:00:00", rate=30.0))
    assert "near 10:15:00:00: cam2 (11:15:00:00, 3599.98 s after most)" in found.problem


def test_codes_that_go_over_midnight_are_of_one_night() -> None:
    found = starts_by_timecode(starts("23:59:59:20", "00:00:00:02", "23:59:59:29", rate=30.0))
    assert [second - found.seconds[0] for second in found.seconds] == pytest.approx([0, 0.4, 0.3])
    assert found.notes == ("the time codes go over midnight",)


def test_cameras_all_apart_are_listed() -> None:
    found = starts_by_timecode(starts("10:00:00:00", "11:00:00:00", "12:00:00:00", rate=30.0))
    assert found.problem.endswith("no moment in common: cam0 10:00:00:00, cam1 11:00:00:00, cam2 12:00:00:00")


@pytest.mark.parametrize("codes", [("10:00:00:00", "10:00:00:00"), ("10:00:00:00", "noon")])
def test_equal_codes_and_none_tell_nothing(codes: tuple[str, str]) -> None:
    assert starts_by_timecode(starts(*codes)).seconds == ()
