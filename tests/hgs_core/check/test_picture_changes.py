from __future__ import annotations

import numpy as np
import pytest

from hgs_core.check.picture_changes import picture_changes, same_picture, watched_frames


def test_energy_is_what_changes_beyond_noise() -> None:
    numbers = np.random.default_rng(6)
    still = numbers.integers(100, 104, (3, 96, 128, 3)).astype(np.uint8)
    moved = still.copy()
    moved[2, :48] += 50
    changes = picture_changes(moved.__getitem__, range(3))
    assert changes.energy[0] == 0
    assert changes.energy[1] == pytest.approx(25, abs=2)


def test_a_change_at_the_border_is_not_inside() -> None:
    film = np.full((3, 96, 128, 3), 90, np.uint8)
    film[1:, 40:60, 40:60] = 200
    film[2, 40:60, :20] = 200
    assert picture_changes(film.__getitem__, range(3)).inside.tolist() == [True, False]


def test_a_blank_picture_has_no_spread() -> None:
    film = np.full((1, 96, 128, 3), 7, np.uint8)
    changes = picture_changes(film.__getitem__, [0])
    assert (changes.level[0], changes.spread[0]) == pytest.approx((7, 0))


def test_pictures_that_differ_by_noise_are_the_same() -> None:
    film = np.full((3, 96, 128, 3), 90, np.uint8)
    film[1] += 5
    film[2, :10] += 50
    assert same_picture(film.__getitem__, 0, 1)
    assert not same_picture(film.__getitem__, 0, 2)


@pytest.mark.parametrize("count", [1, 2, 89, 90, 91, 100, 122, 123, 5000])
def test_the_first_and_the_last_frame_are_watched(count: int) -> None:
    frames = watched_frames(count)
    assert (frames[0], frames[-1]) == (0, count - 1)
    assert (np.diff(frames) > 0).all()
    assert len(frames) <= 122
