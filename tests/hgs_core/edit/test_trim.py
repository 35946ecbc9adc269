"""A trimmed scene at t is the scene at t + start, drawn by the reference in float64."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.edit.trim import trim
from tests.hgs_core.edit.scenes import CAMERAS, moving, picture, splats, still
from tests.tolerances import TOLERANCES

RTOL, ATOL = TOLERANCES["float32"]


@pytest.mark.parametrize("coefficients", [4, 6])
@pytest.mark.parametrize(("start", "end"), [(2.3, 3.1), (2.9, 4.4), (3.65, 5.3), (2.0, 3.68), (4.0, 4.01)])
def test_a_trimmed_scene_shows_what_the_scene_shows(start: float, end: float, coefficients: int) -> None:
    """In one segment, over the border of two, and in the gap in which the first is shown past its end."""
    viewed = moving(3, coefficients)
    edit = trim(viewed, start, end)
    assert edit.viewed.scene.start == 0
    for seconds in np.linspace(start, end - 1e-6, 5):
        given = picture(viewed, CAMERAS[1], float(seconds))
        np.testing.assert_allclose(picture(edit.viewed, CAMERAS[1], float(seconds) - start), given, RTOL, ATOL)


def test_what_lives_before_or_after_is_left_out_and_counted() -> None:
    viewed = moving()
    edit = trim(viewed, 2.5, 2.8)
    assert len(edit.viewed.scene.segments) == 1
    gone = splats(viewed) - splats(edit.viewed)
    assert gone > 60  # all of the second segment, and some of the first
    assert [(c.count, c.of, c.reason) for c in edit.changes] == [(gone, 240, "they do not live from 2.5 to 2.8 s")]


def test_trimming_twice_is_trimming_once() -> None:
    viewed = moving(4)
    twice = trim(trim(viewed, 2.2, 5.0).viewed, 0.3, 1.9).viewed
    once = trim(viewed, 2.5, 4.1).viewed
    assert [len(s.dynamic) for s in twice.scene.segments] == [len(s.dynamic) for s in once.scene.segments]
    for a, b in zip(twice.scene.segments, once.scene.segments, strict=True):
        assert (a.start, a.end) == (pytest.approx(b.start), pytest.approx(b.end))
        np.testing.assert_allclose(a.dynamic.motion, b.dynamic.motion, rtol=1e-6)


def test_frames_are_those_of_the_stretch_on_its_own_clock() -> None:
    np.testing.assert_allclose(trim(moving(), 2.25, 2.6).viewed.times, [0.05, 0.15, 0.25, 0.35], atol=1e-9)


@pytest.mark.parametrize(("start", "end"), [(1.9, 3), (3, 5.4), (3, 3), (4, 3)])
def test_what_is_no_stretch_of_the_scene_is_refused(start: float, end: float) -> None:
    with pytest.raises(
        InputError, match=f"--trim: {start:g} to {end:g} s is no stretch of the scene; give two seconds"
    ):
        trim(moving(), start, end)


def test_too_little_of_a_segment_is_refused() -> None:
    with pytest.raises(InputError, match=r"holds only .* s of segment 1; move that end by a frame"):
        trim(moving(), 2.0, 3.70001)


def test_a_scene_without_time_is_refused() -> None:
    with pytest.raises(InputError, match="of a scene that lasts no time"):
        trim(still(), 0.0, 1.0)
