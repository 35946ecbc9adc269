"""Compensation of exposure: known gains and offsets are undone, and changes of the scene are left alone."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.decompose.exposure import compensated


def texture(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(30, 200, (12, 16, 3)).repeat(8, 0).repeat(8, 1).astype(np.uint8)


def exposed(picture: np.ndarray, gain: float, offset: float = 0.0) -> np.ndarray:
    return (picture * gain + offset).round().clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize(("gain", "offset"), [(0.8, 0), (0.95, 0), (1.05, 0), (1.2, 0), (1.0, 8), (0.93, -6)])
def test_a_gain_and_an_offset_are_undone(gain: float, offset: float) -> None:
    result = compensated(exposed(texture(), gain, offset), texture())
    assert np.abs(result.astype(int) - texture()).max() <= 2


def test_channels_have_gains_of_their_own() -> None:
    warm = exposed(texture(), np.array([1.06, 1.0, 0.94]))  # type: ignore[arg-type]
    assert np.abs(compensated(warm, texture()).astype(int) - texture()).max() <= 2


def test_noise_does_not_bend_the_fit() -> None:
    noise = np.random.default_rng(1).normal(0, 10, texture().shape)
    result = compensated(exposed(texture() + noise, 0.95), texture())
    assert abs(float((result.astype(int) - texture()).mean())) < 0.7


def test_what_moves_keeps_its_difference() -> None:
    picture = texture()
    picture[20:60, 20:80] = (250, 10, 10)
    result = compensated(exposed(picture, 0.95), texture()).astype(int)
    moved = np.zeros(picture.shape[:2], bool)
    moved[20:60, 20:80] = True
    assert np.abs(result - texture())[~moved].max() <= 2
    assert np.abs(result - picture)[moved].max() <= 6


def test_an_unchanged_picture_is_returned_as_it_is() -> None:
    picture = texture()
    picture[:30, :30] = 0
    assert compensated(picture, texture()) is picture


@pytest.mark.parametrize("gain", [0.5, 1.6])
def test_light_that_changes_is_not_compensated(gain: float) -> None:
    picture = exposed(texture() // 2 + 20, gain)
    assert compensated(picture, texture() // 2 + 20) is picture


def test_another_picture_is_not_made_alike() -> None:
    other = texture(5)
    assert np.abs(compensated(other, texture()).astype(int) - other).mean() < 12


def test_clipped_pixels_do_not_seem_to_darken() -> None:
    background = texture()
    background[:40] = 240
    bright = exposed(background, 1.1)
    result = compensated(bright, background)
    assert (result[:40] >= 240).all()


def test_a_blank_picture_is_no_obstacle() -> None:
    blank = np.full((40, 53, 3), 90, np.uint8)
    assert np.abs(compensated(exposed(blank, 1.05), blank).astype(int) - 90).max() <= 2
    black = np.zeros((40, 53, 3), np.uint8)
    assert compensated(black, black) is black
