from __future__ import annotations

import numpy as np
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st

from hgs_core.codec.format.streams import (
    Transform,
    compress,
    decompress,
    from_planes,
    to_planes,
    transform,
    undo_transform,
)


@st.composite
def codes_and_bits(draw: st.DrawFn) -> tuple[np.ndarray, int]:
    bits = draw(st.integers(1, 24))
    rows = draw(st.lists(st.lists(st.integers(0, (1 << bits) - 1), min_size=3, max_size=3), min_size=1, max_size=30))
    return np.array(rows, np.uint32), bits


@given(codes_and_bits(), st.sampled_from(Transform))
def test_transforms_are_undone_and_stay_below_two_to_the_bits(given: tuple[np.ndarray, int], kind: Transform) -> None:
    codes, bits = given
    changed = transform(codes, bits, kind)
    assert (changed < 1 << bits).all()
    undone = undo_transform(
        from_planes(np.array([np.frombuffer(p, np.uint8) for p in to_planes(changed, bits)]), bits), bits, kind
    )
    np.testing.assert_array_equal(undone.T, codes)


def test_a_chain_stores_differences_of_components() -> None:
    codes = np.array([[9, 7, 7], [200, 200, 3]], np.uint32)
    assert transform(codes, 8, Transform.CHAIN).tolist() == [[9, 3, 0], [200, 0, 2 * 59]]


def test_small_differences_become_small_codes() -> None:
    codes = np.array([[5], [4], [4], [6]], np.uint32)
    assert transform(codes, 8, Transform.DELTA)[:, 0].tolist() == [10, 1, 0, 4]


@given(codes_and_bits())
def test_planes_are_joined_again(given: tuple[np.ndarray, int]) -> None:
    codes, bits = given
    planes = np.array([np.frombuffer(plane, np.uint8) for plane in to_planes(codes, bits)])
    assert planes.shape == (3 * ((bits + 7) // 8), len(codes))
    np.testing.assert_array_equal(from_planes(planes, bits).T, codes)


def test_a_stream_comes_back() -> None:
    assert decompress(memoryview(compress(b"splats" * 100, 19)), 600) == b"splats" * 100


@pytest.mark.parametrize(
    ("frame", "problem"),
    [
        (b"", "damaged"),
        (b"not a frame", "damaged"),
        (compress(b"x" * 50, 3)[:-1], "damaged"),
        (compress(b"x" * 49, 3), "a frame of 49 bytes"),
        (compress(b"x" * (1 << 24), 3), "a frame of 16777216 bytes"),
        (compress(b"x" * 50, 3) + b"more", "damaged"),
        (zstandard.ZstdCompressor(write_content_size=False).compress(b"x" * 50), "without content size"),
    ],
)
def test_what_is_not_one_frame_of_the_length_is_refused(frame: bytes, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        decompress(memoryview(frame), 50)
