"""OpenEXR files of depths: scan lines of half or full floats, plain, run-length coded or deflated (openexr.com)."""

from __future__ import annotations

import math
import shlex
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.base.wording import shown

__all__ = ["ExrHeader", "read_exr", "read_exr_header"]

_MAGIC = b"\x76\x2f\x31\x01"
_FLAGS = 0x1E00  # tiles, long names, several parts or samples; long names alone are read
_LONG_NAMES = 0x0400
_LINES = {0: 1, 1: 1, 2: 1, 3: 16}  # compression -> scan lines of a block: none, runs, deflated lines or blocks
_RUNS = 1
_KINDS = {0: "<u4", 1: "<f2", 2: "<f4"}
_DEPTH_NAMES = ("z", "depth", "v", "y", "r")  # last parts of the names of a depth's channel, the likeliest first
_MOST_HEADER = 1 << 20  # bytes
_MOST_PIXELS = 40_000_000
_CURE = "restore the file from its source"


@dataclass(frozen=True)
class ExrHeader:
    """The header of a file, and the channel that holds depths."""

    size: tuple[int, int]  # width and height, pixels
    top: int  # row of the first scan line
    compression: int
    channels: tuple[tuple[str, str], ...]  # names and numpy's types, in the file's order
    depth: int  # place of the depth channel
    end: int  # bytes, up to the table of offsets


def read_exr_header(path: Path) -> ExrHeader:
    """Return the header of a file.

    Raises:
        InputError: it is missing, no OpenEXR file, damaged, or of a kind that is not read.
    """
    try:
        with path.open("rb") as file:
            return _header(path, file.read(_MOST_HEADER))
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", _CURE) from error


def read_exr(path: Path) -> npt.NDArray[np.float32]:
    """Return the depths [H, W] of a file as they are stored.

    Raises:
        InputError: as `read_exr_header`, or the pixels are damaged.
    """
    header = read_exr_header(path)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read ({error.strerror})", _CURE) from error
    width, height = header.size
    kinds = [np.dtype(kind) for _, kind in header.channels]
    line = width * sum(kind.itemsize for kind in kinds)
    before = width * sum(kind.itemsize for kind in kinds[: header.depth])
    lines = _LINES[header.compression]
    blocks = -(-height // lines)
    if header.end + 8 * blocks > len(data):
        raise _damaged(path, f"its table of {blocks} offsets ends too early")
    found = np.full((height, width), np.nan, np.float32)
    for offset in struct.unpack_from(f"<{blocks}Q", data, header.end):
        if offset + 8 > len(data):
            raise _damaged(path, f"a block begins at byte {offset} of {len(data)}")
        row, size = struct.unpack_from("<ii", data, offset)
        row -= header.top
        if not 0 <= row < height or size < 0 or offset + 8 + size > len(data):
            raise _damaged(path, f"a block of {size} bytes begins in row {row} of {height}")
        count = min(lines, height - row)
        raw = _unpacked(path, data[offset + 8 : offset + 8 + size], header.compression, count * line)
        values = np.frombuffer(raw, np.uint8).reshape(count, line)[
            :, before : before + width * kinds[header.depth].itemsize
        ]
        with np.errstate(over="ignore", invalid="ignore"):
            found[row : row + count] = np.ascontiguousarray(values).view(kinds[header.depth]).astype(np.float32)
    return found


def _header(path: Path, data: bytes) -> ExrHeader:
    if not data.startswith(_MAGIC) or len(data) < 8:
        raise InputError(path, "is no OpenEXR file", "give depth maps as 16-bit PNG or EXR")
    (version,) = struct.unpack_from("<I", data, 4)
    if version & _FLAGS & ~_LONG_NAMES:
        raise InputError(path, "has tiles, or several parts or samples", _converted(path))
    fields: dict[bytes, bytes] = {}
    at = 8
    while True:
        name, at = _text(path, data, at)
        if not name:
            break
        _, at = _text(path, data, at)
        if at + 4 > len(data):
            raise _damaged(path, "its header ends too early")
        (size,) = struct.unpack_from("<i", data, at)
        at += 4
        if size < 0 or at + size > len(data):
            raise _damaged(path, "its header ends too early")
        fields[name] = data[at : at + size]
        at += size
    compression, window = fields.get(b"compression", b""), fields.get(b"dataWindow", b"")
    if len(compression) != 1 or len(window) != 16:
        raise _damaged(path, "its header lacks compression or dataWindow")
    if compression[0] not in _LINES:
        raise InputError(path, f"has the compression number {compression[0]}", _converted(path))
    left, top, right, bottom = struct.unpack("<4i", window)
    width, height = right - left + 1, bottom - top + 1
    if width < 1 or height < 1 or width * height > _MOST_PIXELS:
        raise _damaged(path, f"it announces {width}x{height} pixels")
    channels = _channels(path, fields.get(b"channels", b""))
    return ExrHeader((width, height), top, compression[0], channels, _depth_of(path, channels), at)


def _channels(path: Path, data: bytes) -> tuple[tuple[str, str], ...]:
    found = []
    at = 0
    while at < len(data) and data[at]:
        name, at = _text(path, data, at)
        if at + 16 > len(data):
            raise _damaged(path, "its list of channels ends too early")
        kind, _, across, down = struct.unpack_from("<iIii", data, at)
        at += 16
        if kind not in _KINDS or (across, down) != (1, 1):
            raise InputError(path, "has channels of another type or size", _converted(path))
        found.append((name.decode("utf-8", "replace"), _KINDS[kind]))
    return tuple(found)


def _depth_of(path: Path, channels: tuple[tuple[str, str], ...]) -> int:
    """Return the place of the depth channel: the only one, or the one with the likeliest name."""
    if len(channels) == 1:
        return 0
    ends = [name.lower().rpartition(".")[2] for name, _ in channels]
    for likely in _DEPTH_NAMES:
        if ends.count(likely) == 1:
            return ends.index(likely)
    listed = shown(", ".join(name for name, _ in channels))
    raise InputError(path, f"has the channels {listed}, none of which is a depth", "call one Z")


def _unpacked(path: Path, packed: bytes, compression: int, size: int) -> bytes:
    """Return the `size` bytes of a block; one that compression would have made longer is stored as it is."""
    if compression == 0 or len(packed) == size:
        raw = packed
    else:
        coded = _of_runs(path, packed, size) if compression == _RUNS else _inflated(path, packed, size)
        if len(coded) != size:
            raise _damaged(path, f"a block has {len(coded)} bytes, {size} belong there")
        steps = np.frombuffer(coded, np.uint8).astype(np.uint64)
        steps[1:] += 128  # every byte is the difference to the one before, plus 128
        halves = np.cumsum(steps).astype(np.uint8)
        mixed = np.empty(size, np.uint8)
        mixed[0::2], mixed[1::2] = halves[: math.ceil(size / 2)], halves[math.ceil(size / 2) :]
        raw = mixed.tobytes()
    if len(raw) != size:
        raise _damaged(path, f"a block has {len(raw)} bytes, {size} belong there")
    return raw


def _inflated(path: Path, packed: bytes, size: int) -> bytes:
    try:
        return zlib.decompressobj().decompress(packed, size + 1)
    except zlib.error as error:
        raise _damaged(path, f"a block is damaged ({error})") from error


def _of_runs(path: Path, packed: bytes, size: int) -> bytes:
    found = bytearray()
    at = 0
    while at < len(packed) and len(found) <= size:
        count = packed[at] - 256 if packed[at] > 127 else packed[at]
        if count < 0:
            found += packed[at + 1 : at + 1 - count]
            at += 1 - count
        else:
            found += packed[at + 1 : at + 2] * (count + 1)
            at += 2
    return bytes(found)


def _text(path: Path, data: bytes, at: int) -> tuple[bytes, int]:
    """Return the text up to a zero byte, and where it ends."""
    end = data.find(b"\0", at, at + 256)
    if end < 0:
        raise _damaged(path, "its header ends too early")
    return data[at:end], end + 1


def _damaged(path: Path, problem: str) -> InputError:
    return InputError(path, f"the depth map is damaged: {problem}", _CURE)


def _converted(path: Path) -> str:
    name = shlex.quote(path.name)
    return f"store scan lines, deflated: oiiotool {name} --scanline --compression zip -o {name}"
