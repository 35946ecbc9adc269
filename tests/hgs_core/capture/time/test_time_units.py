"""Units of time by the names of columns and by steps from frame to frame."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.capture.time.time_units import UNITS, unit_in_name, unit_of_step


@pytest.mark.parametrize(
    ("column", "name", "unit"),
    [
        ("frame_time", "frame_time", None),
        ("Frame Time (ms)", "frame_time", "milliseconds"),
        ("frameTime_us", "frame_time", "microseconds"),
        ("timestamp [ns]", "timestamp", "nanoseconds"),
        ("t/µs", "t", "microseconds"),
        ("seconds", "", "seconds"),
        ("CAM_ID", "cam_id", None),
        ("", "", None),
    ],
)
def test_the_end_of_a_name_tells_the_unit(column: str, name: str, unit: str | None) -> None:
    found, of = unit_in_name(column)
    assert (found, of and of.name) == (name, unit)


@given(st.sampled_from(UNITS), st.floats(5.0, 240.0), st.floats(0.6, 1.6))
def test_a_step_near_the_rate_is_in_its_unit(unit: object, rate: float, off: float) -> None:
    known = next(one for one in UNITS if one is unit)
    step = known.per_second / rate
    assert unit_of_step(step * off, rate) is known
    assert unit_of_step(step, None) is known


@given(st.sampled_from(UNITS), st.floats(5.0, 240.0), st.sampled_from([3.0, 10.0, 30.0, 100.0, 300.0]))
def test_a_step_between_units_is_in_none(unit: object, rate: float, off: float) -> None:
    known = next(one for one in UNITS if one is unit)
    assert unit_of_step(known.per_second / rate * off, rate) is None


@pytest.mark.parametrize("step", [0.0, -1.0, float("nan")])
def test_no_step_has_no_unit(step: float) -> None:
    assert unit_of_step(step, None) is None
    assert unit_of_step(step, 30.0) is None
