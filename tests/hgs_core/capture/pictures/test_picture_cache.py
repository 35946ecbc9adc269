from __future__ import annotations

import numpy as np
import pytest

from hgs_core.capture.pictures.picture_cache import FrameCache

PICTURE = 4 * 5 * 3  # bytes


def picture(grey: int = 0) -> np.ndarray:
    return np.full((4, 5, 3), grey, np.uint8)


def test_a_picture_comes_back_by_camera_and_frame() -> None:
    cache = FrameCache(9 * PICTURE)
    cache.put(1, 2, picture(12))
    cache.put(2, 1, picture(21))
    found = [cache.get(*key) for key in ((1, 2), (2, 1), (1, 1))]
    assert [None if one is None else int(one[0, 0, 0]) for one in found] == [12, 21, None]


def test_a_picture_used_lately_outlives_an_older_one() -> None:
    cache = FrameCache(2 * PICTURE)
    for frame in (0, 1):
        cache.put(0, frame, picture())
    cache.get(0, 0)
    cache.put(0, 2, picture())
    assert cache.get(0, 0) is not None
    assert cache.get(0, 1) is None


@pytest.mark.parametrize(("limit", "held"), [(0, 0), (PICTURE - 1, 0), (PICTURE, 1), (3 * PICTURE + 1, 3)])
def test_no_more_is_held_than_the_limit_allows(limit: int, held: int) -> None:
    cache = FrameCache(limit)
    for frame in range(5):
        cache.put(0, frame, picture())
    assert cache.bytes_held == held * PICTURE
    assert [cache.get(0, frame) is not None for frame in range(5)] == [frame >= 5 - held for frame in range(5)]


def test_a_picture_held_already_is_neither_replaced_nor_counted_again() -> None:
    cache = FrameCache(9 * PICTURE)
    cache.put(0, 0, picture(1))
    cache.put(0, 0, picture(2))
    found = cache.get(0, 0)
    assert found is not None
    assert found.max() == 1
    assert cache.bytes_held == PICTURE


def test_nobody_can_change_a_picture_that_others_share() -> None:
    cache, shared = FrameCache(PICTURE), picture()
    cache.put(0, 0, shared)
    with pytest.raises(ValueError, match="read-only"):
        shared[0, 0] = 1


def test_large_pictures_are_held_apart_from_what_comes_and_goes() -> None:
    large = np.arange(700 * 600 * 3, dtype=np.uint32).astype(np.uint8).reshape(700, 600, 3)
    cache = FrameCache(large.nbytes)
    cache.put(0, 0, large)
    held = cache.get(0, 0)
    assert held is not None
    np.testing.assert_array_equal(held, large)
    assert not np.shares_memory(held, large)
    assert not held.flags.writeable
