"""Steps worked out by hand for balls and needles of known size."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.codec.encoder.encode_settings import EncodeSettings
from hgs_core.codec.encoder.steps import BLUR_DEVIATION, Steps, ideal_position_steps, screen_deviations
from tests.hgs_core.codec.encoder.prepared import prepared

SETTINGS = EncodeSettings()


def test_deviations_on_the_screen_have_what_rendering_adds() -> None:
    found = screen_deviations(prepared(1, log_scale=np.log([[0.03, 0.02, 1e-9]]), scale=100.0))
    np.testing.assert_allclose(found, np.sqrt([[9.3, 4.3, 0.3]]))


def test_a_place_may_be_off_by_a_share_of_the_splats_radius_and_less_where_it_shows_more() -> None:
    """A ball of deviation 4 pixels, 100 pixels to the unit."""
    radius = np.sqrt(16.3) / 100
    splats = prepared(3, log_scale=np.log(0.04), utility=[1.0, 4.0, 16 / 25])
    expected = SETTINGS.position_step * radius * np.array([1, 1 / 2, 5 / 4])
    np.testing.assert_allclose(ideal_position_steps(splats, SETTINGS), expected)
    coarse = EncodeSettings(coarseness=1.1)
    np.testing.assert_allclose(ideal_position_steps(splats, coarse), 1.1 * expected)


def test_a_step_is_no_wider_than_half_a_pixel_and_no_finer_than_floats_hold() -> None:
    wide = prepared(1, utility=1e-9)
    np.testing.assert_allclose(ideal_position_steps(wide, SETTINGS), SETTINGS.largest_position_step / 100)
    far = prepared(1, log_scale=np.log(1e-4), position=[[0, -8e5, 3]])
    np.testing.assert_allclose(ideal_position_steps(far, SETTINGS), 8e5 * 2.0**-21)


@pytest.mark.parametrize(("utility", "width"), [(1.0, 1.0), (16.0, 1 / 4), (1 / 16, 4.0)])
def test_a_grade_is_a_factor_of_two_in_the_steps_of_colour_and_shape(utility: float, width: float) -> None:
    steps = Steps.of(prepared(5, utility=utility), SETTINGS)
    assert steps.rgb == pytest.approx(width * SETTINGS.rgb_step, rel=1e-6)
    assert steps.shape == pytest.approx(width * SETTINGS.shape_step, rel=1e-6)
    assert Steps.of(prepared(5, utility=utility), EncodeSettings(coarseness=0.5)).rgb == pytest.approx(0.5 * steps.rgb)


def test_the_finest_grade_of_a_chunk_counts_and_every_splat_keeps_its_own_weight() -> None:
    steps = Steps.of(prepared(3, utility=[1.0, 16.0, 1 / 4]), SETTINGS)
    assert steps.rgb == pytest.approx(SETTINGS.rgb_step / 4, rel=1e-6)
    np.testing.assert_allclose(steps.own_rgb, SETTINGS.rgb_step * np.array([1, 1 / 4, 2]))
    np.testing.assert_allclose(steps.own_shape, SETTINGS.shape_step * np.array([1, 1 / 4, 2]))


def test_steps_of_what_hardly_shows_are_limited() -> None:
    steps = Steps.of(prepared(2, utility=1e-4), EncodeSettings(coarseness=9.0))
    limits = SETTINGS.largest_rgb_step, SETTINGS.largest_shape_step, SETTINGS.largest_opacity_step
    assert (steps.rgb, steps.shape, steps.opacity) == pytest.approx(limits, rel=1e-6)
    np.testing.assert_allclose(steps.own_rgb, SETTINGS.largest_rgb_step)


def test_an_opacitys_step_is_a_share_of_it_in_the_number_that_is_stored() -> None:
    """The opacity is x x (3 - 2 x) of the number x, with slope 6 x (1 - x): of 0.5 at x = 0.5 it is 1.5."""
    steps = Steps.of(prepared(4, opacity=0.5), SETTINGS)
    assert steps.opacity == pytest.approx(SETTINGS.opacity_step * 0.501 / 1.501, rel=1e-6)


def test_a_chunks_step_of_place_has_the_mean_precision_of_its_splats() -> None:
    splats = prepared(2, log_scale=np.log(0.04), utility=[1.0, 1 / 9])
    own = ideal_position_steps(splats, SETTINGS)
    steps = Steps.of(splats, SETTINGS)
    assert steps.position == pytest.approx(((own[0] ** -2 + own[1] ** -2) / 2) ** -0.5, rel=1e-6)
    np.testing.assert_allclose(steps.own_position, own)


def test_rotations_of_balls_have_the_widest_step_and_of_needles_one_by_how_long_they_are() -> None:
    assert Steps.of(prepared(5), SETTINGS).rotation == pytest.approx(SETTINGS.largest_rotation_step, rel=1e-6)
    needle = prepared(5, log_scale=np.log([[0.4, 0.04, 0.04]]))
    longer = np.sqrt(1600.3 / 16.3)
    expected = SETTINGS.rotation_step * SETTINGS.shape_step / (longer - 1 / longer)
    assert Steps.of(needle, SETTINGS).rotation == pytest.approx(expected, rel=1e-6)


def test_where_turns_decide_how_strong_a_splat_is_rotations_are_finer() -> None:
    strong = prepared(5, strength_by_turn=[[0.0, 0.0, 12.0]])
    expected = SETTINGS.rotation_step * SETTINGS.shape_step / np.sqrt(12 * 3)  # a turn counts a third of a scale
    assert Steps.of(strong, SETTINGS).rotation == pytest.approx(expected, rel=1e-6)


def test_steps_are_exact_in_float32_and_the_blur_is_a_tenth_of_a_pixel() -> None:
    steps = Steps.of(prepared(3, utility=[0.7, 1.3, 2.9], scale=[50.0, 80.0, 400.0]), SETTINGS)
    for name in ("position", "blur", "shape", "rotation", "opacity", "rgb"):
        assert float(np.float32(getattr(steps, name))) == getattr(steps, name), name
    assert steps.blur == pytest.approx(BLUR_DEVIATION / 80, rel=1e-6)
