"""SPZ files (Niantic, versions 2 to 4): static splats in fixed point, 19 or 20 bytes each before compression.

Versions 2 and 3 are gzipped as a whole: a header of 16 bytes (magic "NGSP", version, count, SH degree, fractional bits,
flags), the planes, records of extensions. In version 4 nothing but the planes is compressed, each by zstd for itself: a
header of 32 bytes, which goes on with the number of planes and where their table is, the records of extensions, the
table of compressed and plain sizes, the planes. Facts from the format's README (github.com/nianticlabs/spz).
"""

from __future__ import annotations

import gzip
import io
import struct
import zlib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import zstandard

from hgs_core.base.arrays import Floats
from hgs_core.base.errors import InputError
from hgs_core.interchange.changes import Action, Change, Written
from hgs_core.interchange.file_bytes import file_bytes
from hgs_core.interchange.file_format import FileFormat, Reading, ReadSplats, WriteStill
from hgs_core.interchange.spz.spz_planes import DEGREES, Planes, pack, unpack, widths
from hgs_core.scene.splats import StaticSplats

__all__ = ["SPZ", "read_spz", "spz_file"]

USUAL = 3  # every reader takes it, and at degree 0 version 4 saves a twenty-fifth
HEADER = struct.Struct("<4sII4B")  # magic, version, count, degree, bits, flags, in version 4 the number of planes
TABLE_AT = struct.Struct("<I12x")  # end of the header of version 4
SIZES = struct.Struct("<QQ")  # bytes of a plane: compressed, plain
RECORD = struct.Struct("<II")  # an extension: type, length of its data
MAGIC = b"NGSP"
ANTIALIASED, EXTENSIONS = 1, 2  # flags
AXES, RIGHT_UP_BACK = 0xADBE0003, (0, 4)  # the extension that names the axes, and which of its values are ours to read
ORBIT = 0xADBE0002
LARGEST = 1 << 32  # bytes of a file once it is unpacked
_CURE = "give an SPZ file of version 2 to 4"


class _Unpacked(NamedTuple):
    """A file before its numbers are read."""

    planes: Planes
    bits: int
    flags: int
    records: bytes


def spz_file(splats: StaticSplats[Floats], *, antialiased: bool = False, version: int = USUAL) -> Written:
    """Return an SPZ file of degree 0; version 2 has coarser rotations in a byte less.

    Raises:
        InputError: a position is too far from the origin for 24 bits.
    """
    packed = pack(splats, version)
    planes = [plane.tobytes() for plane in packed.planes if plane.size]
    flags = ANTIALIASED if antialiased else 0
    header = HEADER.pack(MAGIC, version, len(splats), 0, packed.bits, flags, len(planes) if version >= 4 else 0)
    if version < 4:
        return Written(gzip.compress(header + b"".join(planes), 9, mtime=0), packed.changes)
    compressed = [zstandard.ZstdCompressor(level=19).compress(plane) for plane in planes]
    table = b"".join(SIZES.pack(len(short), len(plane)) for short, plane in zip(compressed, planes, strict=True))
    beginning = header + TABLE_AT.pack(HEADER.size + TABLE_AT.size) + table
    return Written(beginning + b"".join(compressed), packed.changes)


def read_spz(path: Path) -> tuple[StaticSplats[Floats], bool, list[Change]]:
    """Read an SPZ file; return the splats, whether they were trained antialiased, and the omissions.

    Raises:
        InputError: the file is missing, damaged, of another version, or in axes other than right, up, back.
    """
    data = file_bytes(path, "an .spz file")
    found = _latest(path, data) if data.startswith(MAGIC) else _gzipped(path, data)
    splats, changes = unpack(found.planes, found.bits)
    if found.flags & EXTENSIONS:
        changes += _extensions(path, found.records)
    return splats, bool(found.flags & ANTIALIASED), changes


def _gzipped(path: Path, data: bytes) -> _Unpacked:
    """Unpack a file of version 2 or 3."""
    try:
        with gzip.open(io.BytesIO(data)) as file:
            plain = file.read(LARGEST + 1)
    except (OSError, EOFError, zlib.error) as error:
        raise InputError(path, f"is not an SPZ file ({error})", _CURE) from error
    if len(plain) < HEADER.size or not plain.startswith(MAGIC):
        raise InputError(path, f"holds {len(plain)} bytes without an SPZ header", _CURE)
    version, count, degree, bits, flags = _header(path, plain, (2, 3))
    each = widths(version, degree)
    end = HEADER.size + count * sum(each)
    if len(plain) < end or (len(plain) > end and not flags & EXTENSIONS):
        raise InputError(path, f"has {len(plain)} bytes, {count} splats need {end}", "copy it again")
    starts = HEADER.size + count * np.cumsum((0, *each))
    planes = [plain[start : start + count * width] for start, width in zip(starts, each, strict=False)]
    return _Unpacked(_planes(planes, count, each), bits, flags, plain[end:])


def _latest(path: Path, data: bytes) -> _Unpacked:
    """Unpack a file of version 4."""
    begins = HEADER.size + TABLE_AT.size
    if len(data) < begins:
        raise InputError(path, f"holds {len(data)} bytes without an SPZ header", _CURE)
    version, count, degree, bits, flags = _header(path, data, (4,))
    each = widths(version, degree)
    filled = [width for width in each if width and count]
    planes, (table,) = data[HEADER.size - 1], TABLE_AT.unpack_from(data, HEADER.size)
    at = table + planes * SIZES.size
    if planes != len(filled) or not begins <= table <= len(data) - planes * SIZES.size:
        raise InputError(path, f"has {planes} planes, and their table at byte {table} of {len(data)}", "copy it again")
    plain = []
    for number, width in enumerate(filled):
        short, size = SIZES.unpack_from(data, table + number * SIZES.size)
        if size != count * width or at + short > len(data):
            problem = f"has a plane of {size} bytes in {short}, {count} splats need {count * width}"
            raise InputError(path, problem, "copy it again")
        plain.append(_decompressed(path, data[at : at + short], size))
        at += short
    plain += [b""] * (len(each) - len(filled))
    return _Unpacked(_planes(plain, count, each), bits, flags, data[begins:table])


def _header(path: Path, data: bytes, versions: tuple[int, ...]) -> tuple[int, int, int, int, int]:
    """Return version, count, degree, fractional bits and flags."""
    _, version, count, degree, bits, flags, _ = HEADER.unpack_from(data)
    if version not in versions or degree >= len(DEGREES) or bits > 23:
        problem = f"is of version {version}, SH degree {degree}, {bits} fractional bits"
        raise InputError(path, problem, "save it as version 4")
    if count * sum(widths(version, degree)) > LARGEST:
        raise InputError(path, f"claims {count:,} splats, which are more than {LARGEST:,} bytes", "split it")
    return version, count, degree, bits, flags


def _decompressed(path: Path, data: bytes, size: int) -> bytes:
    try:
        plain = zstandard.ZstdDecompressor().stream_reader(io.BytesIO(data)).read(size + 1)
    except zstandard.ZstdError as error:
        raise InputError(path, f"holds a damaged plane ({error})", "copy it again") from error
    if len(plain) != size:
        raise InputError(path, f"holds a plane that is not of {size} bytes", "copy it again")
    return plain


def _planes(parts: list[bytes], count: int, each: tuple[int, ...]) -> Planes:
    return Planes(
        *(np.frombuffer(part, np.uint8).reshape(count, width) for part, width in zip(parts, each, strict=True))
    )


def _extensions(path: Path, records: bytes) -> list[Change]:
    """Return the omissions of extensions' records."""
    left, at = [], 0
    while at + RECORD.size <= len(records):
        kind, size = RECORD.unpack_from(records, at)
        content = records[at + RECORD.size : at + RECORD.size + size]
        at += RECORD.size + size
        if kind == AXES:
            named = int.from_bytes(content[:4], "little")
            if named not in RIGHT_UP_BACK:
                problem = f"is in axes other than right, up, back (number {named} of SPZ_ADOBE_coordinate_system)"
                raise InputError(path, problem, "save it without that extension")
            continue
        what = "camera's limits" if kind == ORBIT else f"extension {kind:#010x}"
        left.append(Change.whole(Action.LEFT_OUT, what, "a scene has none such"))
    return left


def _read(path: Path, reading: Reading) -> ReadSplats:
    splats, antialiased, changes = read_spz(path)
    return ReadSplats(splats, antialiased=antialiased, changes=tuple(changes))


def _writer(version: int) -> WriteStill:
    return lambda splats, antialiased: spz_file(splats, antialiased=antialiased, version=version)


SPZ = FileFormat(
    ".spz",
    read=_read,
    write_still=_writer(USUAL),
    versions={version: _writer(version) for version in (2, 3, 4)},
)
