"""The container: header, attribute table, streams, checksum (docs/format.md, "Container"). Little endian."""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass
from typing import Any

from hgs_core.codec.attributes import Kind
from hgs_core.codec.errors import ChunkError
from hgs_core.codec.quantise import Affine

__all__ = ["MAX_CHUNK_BYTES", "MAX_SPLATS", "Box", "Container", "Stream", "pack", "unpack"]

MAGIC = b"HGSC"
VERSION = 1
MAX_SPLATS = 1 << 20
MAX_CHUNK_BYTES = 1 << 28

# magic, version, kind, attributes, splats, index, time range, box, total bytes, reserved
HEADER = struct.Struct("<4sHBBIIdd6fII")
# id, quantiser, transform, components, bits, 3 reserved, offset, length, raw length, bound, step, origin
ENTRY = struct.Struct("<5B3xIIIff4f")
CHECKSUM = struct.Struct("<I")

Box = tuple[tuple[float, float, float], tuple[float, float, float]]  # smallest and largest corner


@dataclass(frozen=True)
class Stream:
    """One row of the attribute table and the compressed bytes it points to."""

    attribute: int
    quantiser: int
    transform: int
    components: int
    grid: Affine
    raw_bytes: int
    data: bytes
    at: int = 0  # byte of the chunk at which its table entry lies; set by `unpack`
    data_at: int = 0  # byte at which its data lies; set by `unpack`


@dataclass(frozen=True)
class Container:
    """A chunk before its attributes are understood."""

    kind: Kind
    count: int
    index: int  # place among the chunks of its scene; makes equal content distinct
    time_range: tuple[float, float]  # seconds
    box: Box
    streams: tuple[Stream, ...]


def pack(container: Container) -> bytes:
    """Return the bytes of a chunk."""
    offset = HEADER.size + ENTRY.size * len(container.streams)
    total = offset + sum(len(s.data) for s in container.streams) + CHECKSUM.size
    parts = [
        HEADER.pack(
            MAGIC, VERSION, container.kind, len(container.streams), container.count, container.index,
            *container.time_range, *container.box[0], *container.box[1], total, 0,
        )
    ]  # fmt: skip
    for s in container.streams:
        origin = (*s.grid.origin, 0.0, 0.0, 0.0)[:4]
        parts.append(
            ENTRY.pack(
                s.attribute, s.quantiser, s.transform, s.components, s.grid.bits,
                offset, len(s.data), s.raw_bytes, s.grid.bound, s.grid.step, *origin,
            )
        )  # fmt: skip
        offset += len(s.data)
    body = b"".join([*parts, *(s.data for s in container.streams)])
    return body + CHECKSUM.pack(zlib.crc32(body))


def unpack(data: bytes) -> Container:
    """Read header and table, and check every size in them; nothing is decompressed.

    Raises:
        ChunkError: the bytes are not a valid container; says which byte and why.
    """
    if len(data) < HEADER.size + CHECKSUM.size:
        raise ChunkError(len(data), "end of the chunk", f"at {len(data)} bytes", f"at least {HEADER.size} + 4")
    magic, version, kind, attributes, count, index, start, end, *rest = HEADER.unpack_from(data)
    corners, (total, reserved) = rest[:6], rest[6:]
    _expect(magic == MAGIC, 0, "magic", magic, MAGIC)
    _expect(version == VERSION, 4, "version", version, VERSION)
    _expect(total == len(data), 56, "total length", total, f"{len(data)}, the length of the chunk")
    _expect(total <= MAX_CHUNK_BYTES, 56, "total length", total, f"at most {MAX_CHUNK_BYTES}")
    (checksum,) = CHECKSUM.unpack_from(data, len(data) - CHECKSUM.size)
    actual = zlib.crc32(memoryview(data)[: -CHECKSUM.size])
    _expect(checksum == actual, len(data) - CHECKSUM.size, "checksum", f"{checksum:#010x}", f"{actual:#010x}")
    _expect(kind in (Kind.STATIC, Kind.DYNAMIC), 6, "kind", kind, "0 (static) or 1 (dynamic)")
    _expect(1 <= count <= MAX_SPLATS, 8, "splat count", count, f"1 to {MAX_SPLATS}")
    _expect(math.isfinite(start) and math.isfinite(end) and start <= end, 16, "time range", (start, end), "ascending")
    _expect(all(map(math.isfinite, corners)), 32, "box", tuple(corners), "finite numbers")
    box: Box = (tuple(corners[:3]), tuple(corners[3:]))
    _expect(all(a <= b for a, b in zip(*box, strict=True)), 32, "box", box, "ascending corners")
    _expect(reserved == 0, 60, "reserved field", reserved, 0)
    return Container(Kind(kind), count, index, (start, end), box, _table(data, attributes))


def _table(data: bytes, attributes: int) -> tuple[Stream, ...]:
    expected = HEADER.size + ENTRY.size * attributes
    limit = len(data) - CHECKSUM.size
    _expect(expected <= limit, 7, "attribute count", attributes, f"at most {(limit - HEADER.size) // ENTRY.size}")
    streams: list[Stream] = []
    for i in range(attributes):
        at = HEADER.size + ENTRY.size * i
        identity, quantiser, transform, components, bits, offset, length, raw, bound, step, *origin = ENTRY.unpack_from(
            data, at
        )
        record = f"attribute {identity} (entry {i})"
        _expect(data[at + 5 : at + 8] == b"\0\0\0", at + 5, f"{record} reserved", data[at + 5 : at + 8], "zeros")
        _expect(all(s.attribute != identity for s in streams), at, record, "a repetition", "each attribute once")
        _expect(offset == expected, at + 8, f"{record} offset", offset, f"{expected}, the end of what precedes it")
        _expect(length <= limit - offset, at + 12, f"{record} length", length, f"at most {limit - offset}")
        _expect(all(map(math.isfinite, (bound, step, *origin))), at + 20, f"{record} grid", (step, *origin), "finite")
        expected = offset + length
        grid = Affine(step, tuple(origin[:components]), bits, bound)
        streams.append(Stream(identity, quantiser, transform, components, grid, raw, data[offset:expected], at, offset))
    _expect(expected == limit, expected, "end of the last stream", expected, f"{limit}, where the checksum begins")
    return tuple(streams)


def _expect(condition: bool, byte: int, record: str, found: Any, expected: Any) -> None:
    if not condition:
        raise ChunkError(byte, record, found, expected)
