"""The container, byte by byte as docs/format.md has it."""

from __future__ import annotations

import struct
import zlib

import pytest

from hgs_core.codec import ChunkError
from hgs_core.codec.format.attributes import Kind
from hgs_core.codec.format.chunk import Bounds, Container, Stream, pack, unpack, varint
from hgs_core.codec.format.quantise import Grid
from tests.conftest import REPOSITORY

VALID = sorted((REPOSITORY / "tests" / "vectors").glob("*.chunk"))
BOX = ((-1.0, -2.0, -3.0), (1.0, 2.0, 3.0))
BOUNDS = Bounds(0.5, 0.25, 0.125, 0.0625, 1.0)
STREAMS = (
    Stream(1, 3, 0, Grid(0.5, (0, -1, 300), 9), (memoryview(b"ab"), memoryview(b""), memoryview(b"c"))),
    Stream(200, 1, 7, Grid(2.0, (-64,), 3), (memoryview(b"x" * 128),)),
)
CONTAINER = Container(Kind.DYNAMIC, 5, 7, (1.5, 2.5), BOX, BOUNDS, STREAMS, version=3)
# id, components, bits, transform, planes, step; zeros in zigzag and lengths, both LEB128
TABLE = struct.pack("<5Bf", 1, 3, 9, 0, 3, 0.5) + b"\x00\x01\xd8\x04" + b"\x02\x00\x01"
TABLE += struct.pack("<5Bf", 200, 1, 3, 7, 1, 2.0) + b"\x7f" + b"\x80\x01"
BODY = TABLE + b"abc" + b"x" * 128
HEADER = b"HGSC" + bytes([3, 1, 2, 0]) + struct.pack("<3I", 5, 7, 80 + len(BODY) + 4)
HEADER += struct.pack("<6f", *BOX[0], *BOX[1]) + struct.pack("<2d", 1.5, 2.5) + struct.pack("<5f", *BOUNDS)
CHUNK = HEADER + BODY + struct.pack("<I", zlib.crc32(HEADER + BODY))


def test_a_container_is_the_bytes_of_the_specification() -> None:
    assert pack(CONTAINER) == CHUNK


def test_what_is_read_is_what_was_written_with_the_bytes_at_which_it_lies() -> None:
    found = unpack(CHUNK)
    begin = 80 + len(TABLE)
    first, second = STREAMS
    expected = (
        first._replace(at=80, data_at=(begin, begin + 2, begin + 2)),
        second._replace(at=80 + 16, data_at=(begin + 3,)),
    )
    assert found == Container(Kind.DYNAMIC, 5, 7, (1.5, 2.5), BOX, BOUNDS, expected, version=3)


@pytest.mark.parametrize("path", VALID, ids=lambda path: path.stem)
def test_valid_chunks_are_packed_to_the_same_bytes_again(path: object) -> None:
    data = path.read_bytes()  # type: ignore[attr-defined]
    assert pack(unpack(data)) == data


@pytest.mark.parametrize(
    ("number", "coded"),
    [(0, "00"), (127, "7f"), (128, "8001"), (300, "ac02"), (624485, "e58e26"), ((1 << 32) - 1, "ffffffff0f")],
)
def test_whole_numbers_are_leb128(number: int, coded: str) -> None:
    assert varint(number).hex() == coded


@pytest.mark.parametrize(
    ("at", "value", "byte", "record"),
    [
        (0, b"hgsc", 0, "magic"),
        (4, b"\x04", 4, "version"),
        (5, b"\x02", 5, "kind"),
        (7, b"\x01", 7, "reserved field"),
        (8, b"\0\0\0\0", 8, "splat count"),
        (8, b"\x01\0\x10\0", 8, "splat count"),
        (16, b"\xff", 16, "total length"),
        (20, struct.pack("<f", 1.5), 20, "box"),
        (44, struct.pack("<d", 2.75), 44, "time range"),
        (60, struct.pack("<f", -0.5), 60, "bounds"),
        (80 + 16, b"\x01", 80 + 16, "attribute 1"),  # a second time
        (80 + 13, b"\x7f", 80 + 16, "attribute 200 length"),  # longer by 125 bytes, so that the next goes beyond
        (80 + 13, b"\x01", len(CHUNK) - 5, "end of the last stream"),
    ],
)
def test_what_cannot_be_is_named_with_its_byte(at: int, value: bytes, byte: int, record: str) -> None:
    body = CHUNK[:at] + value + CHUNK[at + len(value) : -4]
    with pytest.raises(ChunkError) as caught:
        unpack(body + struct.pack("<I", zlib.crc32(body)))
    assert (caught.value.byte, caught.value.record) == (byte, record)


def test_a_changed_byte_does_not_fit_the_checksum() -> None:
    with pytest.raises(ChunkError, match="checksum"):
        unpack(CHUNK[:-5] + b"y" + CHUNK[-4:])


def test_every_truncation_is_refused() -> None:
    for length in range(len(CHUNK)):
        with pytest.raises(ChunkError):
            unpack(CHUNK[:length])
