"""The colour map against its promises, in OKLab; OKLab against the table of its author."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.report.error_colours import ERROR_RANGE, colour_table, error_picture, oklab, srgb


def test_oklab_of_known_colours() -> None:
    """White and the primaries, as computed with CSS Color 4's sample code (rounded to 3 digits)."""
    got = oklab(np.array([[1.0, 1, 1], [1, 0, 0], [0, 1, 0], [0, 0, 1]]))
    expected = [[1, 0, 0], [0.628, 0.225, 0.126], [0.866, -0.234, 0.179], [0.452, -0.032, -0.312]]
    np.testing.assert_allclose(got, expected, atol=6e-4)


def test_srgb_undoes_oklab() -> None:
    colours = np.random.default_rng(0).uniform(0, 1, (100, 3))
    np.testing.assert_allclose(srgb(oklab(colours)), colours, atol=1e-6)


def test_steps_are_even_for_the_eye() -> None:
    """Over 16 entries at a time, so that rounding to 8 bits does not count."""
    places = oklab(colour_table()[::15] / 255.0)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert steps.max() / steps.min() < 1.1


def test_lightness_rises_all_the_way() -> None:
    lightness = oklab(colour_table() / 255.0)[:, 0]
    assert (np.diff(lightness) > 0).all()
    assert lightness[-1] - lightness[0] > 0.8


@pytest.mark.parametrize(("error", "entry"), [(0.0, 0), (ERROR_RANGE / 2, 128), (ERROR_RANGE, 255), (0.9, 255)])
def test_errors_find_their_colour(error: float, entry: int) -> None:
    picture = error_picture(np.full((2, 3), error))
    assert picture.shape == (2, 3, 3)
    np.testing.assert_array_equal(picture[1, 2], colour_table()[entry])
