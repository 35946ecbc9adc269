"""Spoiled masks, against dilation by every radius in turn and against the request."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from hgs_core.ablate.mask_changes import blobs_added, components_dropped, eroded, grown_to_share
from hgs_core.decompose.components import component_labels
from hgs_core.decompose.morphology import dilate

masks = arrays(bool, st.tuples(st.integers(1, 12), st.integers(1, 12)))


@settings(deadline=None)
@given(masks, st.floats(0.05, 1))
def test_growth_stops_at_the_first_radius_that_reaches_the_share(mask: np.ndarray, share: float) -> None:
    wanted = mask
    for radius in range(13):
        if mask.any() and wanted.mean() < share:
            wanted = dilate(mask, radius)
    np.testing.assert_array_equal(grown_to_share(mask, share), wanted)


@settings(deadline=None)
@given(masks, st.integers(0, 3))
def test_erosion_keeps_pixels_whose_window_in_the_picture_is_set(mask: np.ndarray, radius: int) -> None:
    padded = np.pad(mask, radius, constant_values=True)
    windows = np.lib.stride_tricks.sliding_window_view(padded, (2 * radius + 1,) * 2)
    np.testing.assert_array_equal(eroded(mask, radius), windows.all(axis=(2, 3)))


def test_components_go_as_a_whole_and_as_often_as_asked() -> None:
    mask = np.zeros((90, 90), bool)
    mask[::3, ::3] = mask[1::3, 1::3] = True  # 900 pairs of pixels that touch at corners
    left = components_dropped(mask, np.random.default_rng(0), 0.3)
    labels = component_labels(mask)
    np.testing.assert_array_equal(left, np.isin(labels, labels[left]) & mask)
    assert len(np.unique(labels[left])) == pytest.approx(630, abs=45)  # three deviations


@pytest.mark.parametrize("chance", [0.0, 1.0])
def test_certain_chances_keep_or_clear_everything(chance: float) -> None:
    mask = np.eye(7, dtype=bool)
    for some in (mask, mask & False):
        left = components_dropped(some, np.random.default_rng(0), chance)
        np.testing.assert_array_equal(left, some & (chance == 0))


def test_discs_cover_the_share_and_clear_nothing() -> None:
    mask = np.zeros((120, 160), bool)
    mask[:2] = True
    (one,) = (blobs_added(mask, _centred(), 1, 0.05) for _ in range(1))
    assert (one >= mask).all()
    assert (one & ~mask).mean() == pytest.approx(0.05, rel=0.02)
    many = [blobs_added(mask & False, np.random.default_rng(seed), 8, 0.05).mean() for seed in range(20)]
    assert 0.035 < np.mean(many) < 0.05  # they overlap and leave the picture


def _centred() -> np.random.Generator:
    """A generator with its first two numbers near the middle."""
    for seed in range(1000):
        if (abs(np.random.default_rng(seed).random(2) - 0.5) < 0.1).all():
            return np.random.default_rng(seed)
    raise AssertionError
