from __future__ import annotations

import pytest

from hgs_core.base.errors import InputError
from hgs_core.bench.raster.raster_sizes import DEFAULT_SIZES, Size, parse_picture_size, parse_sizes


def test_sizes_are_read_in_order_and_once() -> None:
    sizes = parse_sizes("--sizes", "20k@676x507, 1m@1352x1014,20000@676x507,7@8x9")
    assert sizes == (Size(20_000, 676, 507), Size(1_000_000, 1352, 1014), Size(7, 8, 9))


def test_sizes_are_written_as_they_are_read() -> None:
    text = ",".join(map(str, DEFAULT_SIZES))
    assert text.startswith("20k@338x253,")
    assert parse_sizes("--sizes", text) == DEFAULT_SIZES


@pytest.mark.parametrize(
    "text", ["", "20k", "20k@676", "-5@64x48", "0@64x48", "9m@0x48", "11m@64x48", "5@9999x9999", "1.5k@64x48", "5@6x7,"]
)
def test_what_is_no_size_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--sizes: "):
        parse_sizes("--sizes", text)


def test_float64_is_not_afforded_beyond_the_second_default_size() -> None:
    assert [str(size) for size in DEFAULT_SIZES if size.affordable] == ["20k@338x253", "20k@676x507"]


def test_size_of_a_picture_is_read() -> None:
    assert parse_picture_size("--size", " 640X480 ") == (640, 480)


@pytest.mark.parametrize("text", ["", "640", "0x480", "640x-1", "9999x9999", "6 x 4", "640x480x3"])
def test_what_is_no_size_of_a_picture_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="--size: "):
        parse_picture_size("--size", text)
