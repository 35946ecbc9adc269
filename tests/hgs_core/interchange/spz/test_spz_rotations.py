"""Quaternions in a few bytes, packed by hand as the format's description has it."""

from __future__ import annotations

import numpy as np
import pytest

from hgs_core.interchange.spz.spz_rotations import (
    pack_first_three,
    pack_smallest_three,
    unpack_first_three,
    unpack_smallest_three,
)

UNIT = np.array([[0.4, 0.4, -0.2, 0.8]])  # x, y, z, w


def test_first_three_are_bytes_of_the_sign_that_makes_w_positive() -> None:
    stored = [[int(127.5 + 127.5 * x + 0.5) for x in (0.4, 0.4, -0.2)]]
    assert pack_first_three(UNIT).tolist() == stored
    assert pack_first_three(-UNIT).tolist() == stored
    np.testing.assert_allclose(unpack_first_three(pack_first_three(UNIT)), UNIT, atol=1 / 127)


def test_smallest_three_are_signs_and_nine_bits_after_two_that_name_the_largest() -> None:
    share = [int(x * 2**0.5 * 511 + 0.5) for x in (0.4, 0.4, 0.2)]
    word = 3 << 30 | share[0] << 20 | share[1] << 10 | 1 << 9 | share[2]
    assert pack_smallest_three(UNIT).tolist() == [list(word.to_bytes(4, "little"))]
    assert pack_smallest_three(-UNIT).tolist() == [list(word.to_bytes(4, "little"))]


@pytest.mark.parametrize(
    ("pack", "unpack", "most"),
    [
        (pack_first_three, unpack_first_three, 0.12),
        (pack_smallest_three, unpack_smallest_three, 0.003),
    ],
)
def test_any_rotation_comes_back_within_the_steps(pack: object, unpack: object, most: float) -> None:
    """Of x, y, z alone w is the least exact where it is near 0."""
    xyzw = np.random.default_rng(0).normal(size=(2000, 4))
    xyzw /= np.linalg.norm(xyzw, axis=1, keepdims=True)
    found = unpack(pack(xyzw))  # type: ignore[operator]
    error = np.minimum(np.abs(found - xyzw).max(axis=1), np.abs(found + xyzw).max(axis=1))
    assert error.max() < most
