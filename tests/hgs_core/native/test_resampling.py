"""Arguments of the kernel; capture/lenses/test_sensor_places.py compares its results with numpy's."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.native.resampling import resampled

SHARES = np.array([0.0, 0.5], np.float32)


def test_blends_are_rounded() -> None:
    picture = np.array([[0, 10], [20, 31]], np.uint8)[..., None]
    found = resampled(picture, np.zeros(2, np.int32), SHARES, SHARES)
    assert found.ravel().tolist() == [0, 15]  # 15.25


@pytest.mark.parametrize("corner", [-1, 2])
def test_a_corner_without_neighbours_is_refused(corner: int) -> None:
    with pytest.raises(ValueError, match="inside of the picture"):
        resampled(np.zeros((2, 3, 3), np.uint8), np.full(2, corner, np.int32), SHARES, SHARES)


def test_pictures_of_two_channels_are_refused() -> None:
    with pytest.raises(ValueError, match="1 or 3 channels, not 2"):
        resampled(np.zeros((2, 3, 2), np.uint8), np.zeros(2, np.int32), SHARES, SHARES)


def test_shares_are_single_precision() -> None:
    with pytest.raises(ValueError, match="right must be a contiguous float32 array"):
        resampled(np.zeros((2, 3, 3), np.uint8), np.zeros(2, np.int32), np.zeros(2), SHARES)  # type: ignore[arg-type]
