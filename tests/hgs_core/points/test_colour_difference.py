from __future__ import annotations

import numpy as np

from hgs_core.points.colour_difference import colour_difference


def test_mean_difference_of_whole_numbers_is_exact() -> None:
    generator = np.random.default_rng(0)
    first, second = generator.integers(0, 256, (2, 500, 6)).astype(np.int16)

    difference = colour_difference(first, second)

    reference = [
        np.float32(sum(abs(int(a) - int(b)) for a, b in zip(*pair, strict=True)) / 6)
        for pair in zip(first, second, strict=True)
    ]
    assert difference.dtype == np.float32
    np.testing.assert_array_equal(difference, reference)


def test_no_colours_differ_by_nothing() -> None:
    assert colour_difference(np.zeros((0, 3), np.int16), np.zeros((0, 3), np.int16)).shape == (0,)
