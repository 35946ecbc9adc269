"""Box filters and binary morphology, against loops over windows."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hgs_core.decompose.morphology import box_sum, close, despeckle, dilate

masks = arrays(bool, st.tuples(st.integers(1, 9), st.integers(1, 9)))


def windows(values: np.ndarray, radius: int) -> np.ndarray:
    """The window of each pixel, zeros outside the picture, [H, W, (2 radius + 1)^2]."""
    padded = np.pad(values, radius)
    side = 2 * radius + 1
    return np.lib.stride_tricks.sliding_window_view(padded, (side, side)).reshape(*values.shape, -1)


@given(masks, st.integers(0, 3))
def test_box_sum_is_the_sum_of_the_window(mask: np.ndarray, radius: int) -> None:
    np.testing.assert_array_equal(box_sum(mask.astype(np.int16), radius), windows(mask, radius).sum(axis=2))


@given(masks, st.integers(0, 6))
def test_dilation_is_the_maximum_of_the_window(mask: np.ndarray, radius: int) -> None:
    np.testing.assert_array_equal(dilate(mask, radius), windows(mask, radius).any(axis=2))


@given(masks, st.integers(0, 3))
def test_closing_only_adds_and_twice_is_once(mask: np.ndarray, radius: int) -> None:
    closed = close(mask, radius)
    assert (closed >= mask).all()
    np.testing.assert_array_equal(close(closed, radius), closed)


@pytest.mark.parametrize(("gap", "filled"), [(3, True), (8, False)])
def test_closing_fills_narrow_gaps(gap: int, filled: bool) -> None:
    mask = np.ones((20, 30), bool)
    mask[:, 10 : 10 + gap] = False
    assert close(mask, 3).all() == filled


def test_specks_go_and_bodies_stay() -> None:
    mask = np.zeros((20, 20), bool)
    mask[2, 2] = mask[2, 12] = mask[3, 12] = True
    mask[8:18, 8:18] = True
    kept = despeckle(mask, 2, 0.3)
    assert not kept[:6].any()
    np.testing.assert_array_equal(kept[8:18, 8:18], np.ones((10, 10), bool))
