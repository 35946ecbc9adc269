"""One stream at a time, made by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from hgs_core.codec.format.attributes import ATTRIBUTES
from hgs_core.codec.format.chunk import Stream
from hgs_core.codec.format.format_error import ChunkError
from hgs_core.codec.format.quantise import Grid
from hgs_core.codec.format.streams import Transform, compress
from hgs_core.codec.format.values import check_entry, read_codes, read_values

RGB, POSITION = ATTRIBUTES["rgb"], ATTRIBUTES["position"]


def stream(*planes: bytes, bits: int = 8, step: float = 0.5, zeros: tuple[int, ...] = (0, 1, -2)) -> Stream:
    """Planes of an attribute of three components, with its entry at byte 100 and its planes at 200, 300, ..."""
    frames = tuple(memoryview(compress(plane, 3)) for plane in planes)
    places = tuple(200 + 100 * i for i in range(len(planes)))
    return Stream(RGB.id, 3, Transform.NONE, Grid(step, zeros, bits), frames, 100, places)


def test_values_are_steps_from_each_components_zero() -> None:
    found = read_values(stream(bytes([4, 0]), bytes([1, 3]), bytes([0, 255])), RGB, 2)
    assert found.tolist() == [[2.0, 0.0, 1.0], [0.0, 1.0, 128.5]]


def test_codes_of_more_than_a_byte_have_their_low_bytes_first() -> None:
    planes = (bytes([1]), bytes([2]), bytes([3]), bytes([0]), bytes([255]), bytes([15]))
    assert read_codes(stream(*planes, bits=12), RGB, 1).tolist() == [[0x201], [0x003], [0xFFF]]


def test_places_are_read_from_differences_of_interleaved_codes() -> None:
    """Of bits 2 the code has six bits, z1 y1 x1 z0 y0 x0: 0b001010 is (2, 1, 0), and 0b110000 more (2, 3, 2)."""
    planes = (bytes([0b001010, 0b110000]),)
    assert read_codes(stream(*planes, bits=2), POSITION, 2).T.tolist() == [[2, 1, 0], [2, 3, 2]]


@pytest.mark.parametrize(
    ("change", "byte", "field"),
    [
        ({"components": 4}, 101, "components"),
        ({"grid": Grid(0.5, (0, 0, 0), 0)}, 102, "bits"),
        ({"grid": Grid(0.5, (0, 0, 0), 25)}, 102, "bits"),
        ({"transform": 3}, 103, "transform"),
        ({"planes": (memoryview(b""),) * 4}, 104, "planes"),
        ({"grid": Grid(0.0, (0, 0, 0), 8)}, 105, "step"),
        ({"grid": Grid(-1.0, (0, 0, 0), 8)}, 105, "step"),
        ({"grid": Grid(np.inf, (0, 0, 0), 8)}, 105, "step"),
        ({"grid": Grid(np.nan, (0, 0, 0), 8)}, 105, "step"),
    ],
)
def test_a_wrong_number_of_the_entry_is_named_with_its_byte(change: dict[str, object], byte: int, field: str) -> None:
    good = stream(b"\0", b"\0", b"\0")
    check_entry(good, RGB)
    with pytest.raises(ChunkError) as caught:
        check_entry(good._replace(**change), RGB)
    assert (caught.value.byte, caught.value.record) == (byte, f"attribute 5 (rgb) {field}")


def test_a_transform_that_the_attribute_does_not_have_is_refused() -> None:
    chained = stream(b"\0", b"\0", b"\0")._replace(transform=Transform.CHAIN)
    check_entry(chained, RGB)
    with pytest.raises(ChunkError, match="transform: is 2, expected"):
        check_entry(chained, dataclasses.replace(RGB, transforms=(Transform.NONE, Transform.DELTA)))


def test_a_code_of_too_many_bits_is_named_with_the_plane_and_the_row() -> None:
    planes = (bytes([63, 1]), bytes([5, 64]), bytes([0, 0]))
    with pytest.raises(ChunkError) as caught:
        read_codes(stream(*planes, bits=6), RGB, 2)
    assert (caught.value.byte, caught.value.record) == (300, "attribute 5 (rgb) code of row 1")
    assert (caught.value.found, caught.value.expected) == (64, "below 2^6")


def test_places_beyond_the_grid_are_refused_at_their_first_plane() -> None:
    with pytest.raises(ChunkError) as caught:
        read_codes(stream(bytes([0b111111, 1]), bits=2), POSITION, 2)
    assert (caught.value.byte, caught.value.expected) == (200, "below 2^6")


def test_a_plane_that_is_no_frame_of_a_byte_a_row_is_named() -> None:
    with pytest.raises(ChunkError) as caught:
        read_codes(stream(b"\0\0", b"\0", b"\0\0"), RGB, 2)
    assert (caught.value.byte, caught.value.record) == (300, "attribute 5 (rgb) plane 1")
    assert caught.value.expected == "a zstd frame of 2 bytes"
