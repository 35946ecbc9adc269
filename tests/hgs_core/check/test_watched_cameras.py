"""Dead spans are found at any place; a span common to all cameras is none."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hgs_core.check.picture_changes import watched_frames
from hgs_core.check.watched_cameras import DeadSpan, Death, watch_cameras
from tests.hgs_core.check.filmed import CAMERAS, Fault, blank, every, films, frozen, pictures

FRAMES = 40


def watched(
    fault: Fault, frames: int = FRAMES, noise: float = 0.0, cameras: tuple[int, ...] = (2,)
) -> list[tuple[DeadSpan, ...]]:
    filmed = [fault(film) if index in cameras else film for index, film in enumerate(films(frames, noise))]
    return [camera.dead for camera in watch_cameras(pictures(filmed), watched_frames(frames))]


@pytest.mark.parametrize("noise", [0.0, 4.0])
def test_a_sound_capture_has_no_dead_span(noise: float) -> None:
    assert watched(lambda film: film, noise=noise) == [()] * CAMERAS


@given(first=st.integers(0, FRAMES - 12), frames=st.integers(8, FRAMES))
@settings(max_examples=20, deadline=None)
def test_a_frozen_span_is_found_where_it_is(first: int, frames: int) -> None:
    last = min(first + frames, FRAMES) - 1
    *others, (span,) = sorted(watched(frozen(first, last)), key=len)
    assert others == [()] * (CAMERAS - 1)
    assert span.death is Death.FROZEN
    assert (span.first, span.last) == (first, last)


@given(first=st.integers(0, FRAMES - 3), frames=st.integers(1, FRAMES), level=st.sampled_from([0, 9, 128, 255]))
@settings(max_examples=20, deadline=None)
def test_a_blank_span_is_found_where_it_is(first: int, frames: int, level: int) -> None:
    last = min(first + frames, FRAMES) - 1
    *others, (span,) = sorted(watched(blank(first, last, level)), key=len)
    assert others == [()] * (CAMERAS - 1)
    assert (span.death, span.first, span.last) == (Death.BLANK, first, last)
    assert span.level == pytest.approx(level, abs=1)


@pytest.mark.parametrize("step", [2, 3, 4, 5, 6])
def test_repeated_pictures_are_counted(step: int) -> None:
    *_, (span,) = sorted(watched(every(step)), key=len)
    assert span.death is Death.REPEATS
    assert span.repeats == pytest.approx(FRAMES * (1 - 1 / step), abs=3)


@pytest.mark.parametrize("fault", [frozen(10, 30), blank(10, 30, 0), every(2)])
def test_what_happens_to_all_cameras_is_the_scene(fault: Fault) -> None:
    assert watched(fault, cameras=tuple(range(CAMERAS))) == [()] * CAMERAS


def test_a_pause_of_the_scene_does_not_part_a_frozen_span() -> None:
    filmed = [frozen(20, 24)(film) for film in films(FRAMES)]
    filmed[2] = frozen(12, FRAMES - 1)(filmed[2])
    (span,) = watch_cameras(pictures(filmed), watched_frames(FRAMES))[2].dead
    assert (span.first, span.last) == (12, FRAMES - 1)


def test_two_cameras_of_five_may_die() -> None:
    spans = watched(frozen(12, FRAMES - 1), cameras=(1, 3))
    assert [len(one) for one in spans] == [0, 1, 0, 1, 0]


def test_an_object_that_leaves_the_view_is_no_certain_death() -> None:
    def leaving(film: list[np.ndarray]) -> list[np.ndarray]:
        empty = film[0].copy()
        empty[30:70] = 120
        pictures = [empty.copy() for _ in film]
        for frame in range(16):
            pictures[frame][30:70, max(0, 100 - 8 * frame) : max(0, 114 - 8 * frame)] = 230
        return pictures

    *_, spans = sorted(watched(leaving), key=len)
    assert all(not span.certain for span in spans)


def test_noise_that_ends_makes_a_death_certain() -> None:
    *_, (span,) = sorted(watched(frozen(12, FRAMES - 1), noise=4.0), key=len)
    assert span.certain


def test_a_death_between_watched_frames_of_a_long_capture_is_found_to_the_frame() -> None:
    *_, (span,) = sorted(watched(frozen(237, 399), frames=400), key=len)
    assert span.death is Death.FROZEN
    assert (span.first, span.last) == (237, 399)


def test_energy_is_unknown_where_a_camera_is_dead() -> None:
    filmed = films(FRAMES)
    filmed[2] = frozen(30, FRAMES - 1)(filmed[2])
    filmed[4] = frozen(5, FRAMES - 1)(filmed[4])
    energies = [camera.energy() for camera in watch_cameras(pictures(filmed), watched_frames(FRAMES))]
    assert energies[2] is not None
    assert np.flatnonzero(np.isnan(energies[2])).tolist() == list(range(29, FRAMES - 1))
    assert energies[4] is None
