from __future__ import annotations

import numpy as np

from hgs_core.interchange.light import srgb_replaced, to_light, to_srgb


def test_colours_stand_for_the_light_of_the_standard_and_come_back() -> None:
    """IEC 61966-2-1: 0.5 of sRGB is 0.2140 of light, and below 0.04045 light is a 12.92th."""
    rgb = np.array([0.0, 0.02, 0.04045, 0.5, 1.0])
    np.testing.assert_allclose(to_light(rgb), [0, 0.02 / 12.92, 0.0031308, 0.2140411, 1], atol=1e-7)
    np.testing.assert_allclose(to_srgb(to_light(rgb)), rgb, atol=1e-6)


def test_no_light_is_negative() -> None:
    assert to_srgb(np.array([-0.5])).tolist() == [0]


def test_every_splat_is_told_of() -> None:
    assert str(srgb_replaced(7)).startswith("colour of all 7 splats replaced: linear colours by sRGB ones")
