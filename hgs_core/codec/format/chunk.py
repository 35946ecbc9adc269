"""The container: header, attribute table, streams, checksum (docs/format.md, "Container"). Little endian."""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

from hgs_core.codec.format.attributes import Kind
from hgs_core.codec.format.format_error import ChunkError
from hgs_core.codec.format.quantise import MAX_ZERO, Grid

__all__ = [
    "MAX_CHUNK_BYTES",
    "MAX_SPLATS",
    "VERSIONS",
    "Bounds",
    "Box",
    "Container",
    "Stream",
    "pack",
    "unpack",
    "varint",
]

MAGIC = b"HGSC"
VERSIONS = (2, 3)  # format versions; the second has motions of the fifth order
MAX_SPLATS = 1 << 20
MAX_CHUNK_BYTES = 1 << 28

# magic, version, kind, attributes, reserved, splats, index, total bytes, box, time range, bounds
HEADER = struct.Struct("<4s4BIII6f2d5f")
ENTRY = struct.Struct("<5Bf")  # id, components, bits, transform, planes, step; then whole numbers of variable length
CHECKSUM = struct.Struct("<I")
VARINT_BYTES = 5

Box = tuple[tuple[float, float, float], tuple[float, float, float]]  # smallest and largest corner


class Bounds(NamedTuple):
    """Declared errors: no splat of the chunk is farther from the encoder's than this (docs/format.md, "Bounds")."""

    position: float  # world units, per axis, at any moment, in proportion to how far the splat has faded
    blur: float  # world units: the standard deviation added in every direction before shapes are compared
    shape: float  # |ln| of the ratio of standard deviations in any direction
    opacity: float  # largest opacity at any moment
    rgb: float


class Stream(NamedTuple):
    """One row of the attribute table and the compressed planes it points to."""

    attribute: int
    components: int
    transform: int
    grid: Grid
    planes: tuple[memoryview, ...]  # one zstd frame each
    at: int = 0  # byte of the chunk at which its table entry lies; set by `unpack`
    data_at: tuple[int, ...] = ()  # bytes at which its planes lie; set by `unpack`


@dataclass(frozen=True)
class Container:
    """A chunk before its attributes are understood."""

    kind: Kind
    count: int
    index: int  # place among the chunks of its scene; makes equal content distinct
    time_range: tuple[float, float]  # seconds
    box: Box
    bounds: Bounds
    streams: tuple[Stream, ...]
    version: int = VERSIONS[0]


def pack(container: Container) -> bytes:
    """Return the bytes of a chunk."""
    table = b"".join(_entry(stream) for stream in container.streams)
    planes = [plane for stream in container.streams for plane in stream.planes]
    total = HEADER.size + len(table) + sum(map(len, planes)) + CHECKSUM.size
    header = HEADER.pack(
        MAGIC,
        container.version,
        container.kind,
        len(container.streams),
        0,
        container.count,
        container.index,
        total,
        *container.box[0],
        *container.box[1],
        *container.time_range,
        *container.bounds,
    )
    body = b"".join([header, table, *planes])
    return body + CHECKSUM.pack(zlib.crc32(body))


def unpack(data: bytes) -> Container:
    """Read header and table, and check every size in them; nothing is decompressed.

    Raises:
        ChunkError: the bytes are not a valid container; says which byte and why.
    """
    if len(data) < HEADER.size + CHECKSUM.size:
        raise ChunkError(len(data), "end of the chunk", f"at {len(data)} bytes", f"at least {HEADER.size} + 4")
    magic, version, kind, attributes, reserved, count, index, total, *numbers = HEADER.unpack_from(data)
    corners, (start, end), bounds = numbers[:6], numbers[6:8], numbers[8:]
    _expect(magic == MAGIC, 0, "magic", magic, MAGIC)
    _expect(version in VERSIONS, 4, "version", version, " or ".join(map(str, VERSIONS)))
    _expect(total == len(data), 16, "total length", total, f"{len(data)}, the length of the chunk")
    _expect(total <= MAX_CHUNK_BYTES, 16, "total length", total, f"at most {MAX_CHUNK_BYTES}")
    (checksum,) = CHECKSUM.unpack_from(data, len(data) - CHECKSUM.size)
    actual = zlib.crc32(memoryview(data)[: -CHECKSUM.size])
    _expect(checksum == actual, len(data) - CHECKSUM.size, "checksum", f"{checksum:#010x}", f"{actual:#010x}")
    _expect(kind in (Kind.STATIC, Kind.DYNAMIC), 5, "kind", kind, "0 (static) or 1 (dynamic)")
    _expect(reserved == 0, 7, "reserved field", reserved, 0)
    _expect(1 <= count <= MAX_SPLATS, 8, "splat count", count, f"1 to {MAX_SPLATS}")
    _expect(all(map(math.isfinite, corners)), 20, "box", tuple(corners), "finite numbers")
    box: Box = (tuple(corners[:3]), tuple(corners[3:]))
    _expect(all(a <= b for a, b in zip(*box, strict=True)), 20, "box", box, "ascending corners")
    _expect(math.isfinite(start) and math.isfinite(end) and start <= end, 44, "time range", (start, end), "ascending")
    _expect(all(math.isfinite(x) and x >= 0 for x in bounds), 60, "bounds", tuple(bounds), "finite, not negative")
    return Container(Kind(kind), count, index, (start, end), box, Bounds(*bounds), _table(data, attributes), version)


def _entry(stream: Stream) -> bytes:
    grid = stream.grid
    fixed = ENTRY.pack(stream.attribute, stream.components, grid.bits, stream.transform, len(stream.planes), grid.step)
    zeros = [varint(2 * zero if zero >= 0 else -2 * zero - 1) for zero in grid.zeros]
    return b"".join([fixed, *zeros, *(varint(len(plane)) for plane in stream.planes)])


def varint(number: int) -> bytes:
    """Encode a whole number as LEB128: seven bits a byte, low ones first, the highest bit set in all but the last."""
    parts = bytearray()
    while number >= 128:
        parts.append(number & 127 | 128)
        number >>= 7
    parts.append(number)
    return bytes(parts)


def _table(data: bytes, attributes: int) -> tuple[Stream, ...]:
    limit = len(data) - CHECKSUM.size
    at = HEADER.size
    entries: list[tuple[int, int, int, Grid, list[int], int]] = []
    seen: set[int] = set()
    # Many chunks are small: no word of an error is put together before there is one, and no object made twice.
    for i in range(attributes):
        begin = at
        if at + ENTRY.size > limit:
            raise ChunkError(at, f"entry {i}", "cut off", f"{ENTRY.size} bytes before byte {limit}")
        identity, components, bits, kind, planes, step = ENTRY.unpack_from(data, at)
        if identity in seen:
            raise ChunkError(at, f"attribute {identity}", "a repetition", "each attribute once")
        seen.add(identity)
        at += ENTRY.size
        zeros: list[int] = []
        for _ in range(components):
            where = at
            coded, at = _read_varint(data, at, limit, identity, "zero")
            zero = coded >> 1 if coded & 1 == 0 else -(coded + 1 >> 1)
            if not -MAX_ZERO <= zero <= MAX_ZERO:
                raise ChunkError(where, f"attribute {identity} zero", zero, f"at most {MAX_ZERO} from 0")
            zeros.append(zero)
        lengths: list[int] = []
        for _ in range(planes):
            length, at = _read_varint(data, at, limit, identity, "length")
            lengths.append(length)
        entries.append((identity, components, kind, Grid(step, tuple(zeros), bits), lengths, begin))
    view = memoryview(data)
    streams: list[Stream] = []
    for identity, components, kind, grid, lengths, begin in entries:
        places = list(accumulate(lengths, initial=at))
        if places[-1] > limit:
            p = next(p for p, end in enumerate(places[1:]) if end > limit)
            expected = f"at most {limit - places[p]}, what is left"
            raise ChunkError(begin, f"attribute {identity} length", lengths[p], expected)
        frames = tuple([view[start:end] for start, end in pairwise(places)])
        at = places.pop()
        streams.append(Stream(identity, components, kind, grid, frames, begin, tuple(places)))
    _expect(at == limit, at, "end of the last stream", at, f"{limit}, where the checksum begins")
    return tuple(streams)


def _read_varint(data: bytes, at: int, limit: int, identity: int, field: str) -> tuple[int, int]:
    """Return a whole number below 2^32 and the byte after it."""
    # Nearly all have one byte or two. The checksum follows the limit, so reading on needs no check before.
    if data[at] < 128 and at < limit:
        return data[at], at + 1
    if data[at + 1] < 128 and at + 1 < limit:
        return data[at] & 127 | data[at + 1] << 7, at + 2
    number = 0
    for i in range(VARINT_BYTES):
        if at + i >= limit:
            raise ChunkError(at, f"attribute {identity} {field}", "cut off", f"a whole number before byte {limit}")
        byte = data[at + i]
        number |= (byte & 127) << (7 * i)
        if byte < 128:
            if number >= 1 << 32:
                raise ChunkError(at, f"attribute {identity} {field}", number, "below 2^32")
            return number, at + i + 1
    raise ChunkError(at, f"attribute {identity} {field}", f"longer than {VARINT_BYTES} bytes", "below 2^32")


def _expect(condition: bool, byte: int, record: str, found: Any, expected: Any) -> None:
    if not condition:
        raise ChunkError(byte, record, found, expected)
