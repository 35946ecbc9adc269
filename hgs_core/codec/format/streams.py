"""From integer codes to the bytes of a stream and back: transforms, byte planes, one zstd frame per plane.

A stream of C components of b bits has, for each component, ceil(b / 8) planes of one byte per row, low byte first.
"""

from __future__ import annotations

from enum import IntEnum
from threading import local
from typing import Any

import numpy as np
import zstandard
from numpy.typing import NDArray

__all__ = ["Transform", "compress", "decompress", "from_planes", "to_planes", "transform", "undo_transform"]

Codes = NDArray[np.uint32]  # [N, C]
AnyCodes = NDArray[Any]  # [C, N] uint8, uint16 or uint32: the least that holds the bits

_threads = local()


class Transform(IntEnum):
    """The transform of codes before they are split into planes; differences are modulo 2^bits, then zigzag."""

    NONE = 0
    DELTA = 1  # each row minus the one before it (the first minus zero), per component
    CHAIN = 2  # each component minus the one before it; the first as it is


def transform(codes: Codes, bits: int, kind: Transform) -> Codes:
    """Apply a transform to codes [..., N, C]; a chain needs no more than the last axis."""
    if kind == Transform.DELTA:
        before = np.concatenate([np.zeros((1, codes.shape[1]), np.uint32), codes[:-1]])
        return _zigzag(codes - before, bits)
    if kind == Transform.CHAIN:
        return np.concatenate([codes[..., :1], _zigzag(codes[..., 1:] - codes[..., :-1], bits)], axis=-1)
    return codes


def undo_transform(codes: AnyCodes, bits: int, kind: int) -> AnyCodes:
    """Undo `transform` on codes [C, N], in their own type: sums wrap at its size, then at 2^bits."""
    if kind == Transform.NONE:
        return codes
    number = codes.dtype.type
    if kind == Transform.DELTA:
        done = np.cumsum(_unzigzag(codes), axis=1, dtype=number)
    else:
        signed = _unzigzag(codes[1:])
        done = np.empty_like(codes)
        done[0] = codes[0]
        for c, difference in enumerate(signed):
            np.add(done[c], difference, out=done[c + 1])
    done &= number((1 << bits) - 1)
    return done


def to_planes(codes: Codes, bits: int) -> list[bytes]:
    """Split codes [N, C] below 2^bits into byte planes."""
    shifts = [np.uint32(8 * p) for p in range((bits + 7) // 8)]
    return [(codes[:, c] >> s).astype(np.uint8).tobytes() for c in range(codes.shape[1]) for s in shifts]


def from_planes(planes: NDArray[np.uint8], bits: int) -> AnyCodes:
    """Join byte planes [P, N] into codes [C, N]; codes of a byte stay the bytes they are."""
    each = (bits + 7) // 8
    if each == 1:
        return planes
    number: type[np.unsignedinteger[Any]] = np.uint16 if each == 2 else np.uint32
    parts = planes.reshape(-1, each, planes.shape[1])
    codes: AnyCodes = parts[:, each - 1].astype(number)
    for p in range(each - 2, -1, -1):
        codes <<= number(8)
        codes |= parts[:, p]
    return codes


def compress(raw: bytes, level: int) -> bytes:
    """Return one zstd frame that states its content size."""
    return zstandard.ZstdCompressor(level=level, write_checksum=False, write_content_size=True).compress(raw)


def decompress(frame: memoryview, length: int) -> bytes:
    """Return the content of one zstd frame of exactly `length` bytes; no more than that is ever allocated.

    Raises:
        ValueError: it is not one whole frame with that content size.
    """
    decoder: zstandard.ZstdDecompressor | None = getattr(_threads, "decoder", None)
    if decoder is None:
        decoder = _threads.decoder = zstandard.ZstdDecompressor()
    try:
        stated = zstandard.frame_content_size(frame)
        if stated != length:
            raise ValueError("without content size" if stated < 0 else f"a frame of {stated} bytes")
        raw = decoder.decompress(frame, max_output_size=length, allow_extra_data=False)
    except zstandard.ZstdError as error:
        raise ValueError(f"damaged ({error})") from error
    if len(raw) != length:
        raise ValueError(f"a frame of {len(raw)} bytes")
    return raw


def _zigzag(codes: Codes, bits: int) -> Codes:
    """Map differences modulo 2^bits to 0, 1, 2, ... for 0, -1, 1, ..."""
    mask = np.uint32((1 << bits) - 1)
    reduced = codes & mask
    negative = reduced >> np.uint32(bits - 1) != 0
    return np.where(negative, (~reduced & mask) << np.uint32(1) | np.uint32(1), reduced << np.uint32(1)).astype(
        np.uint32
    )


def _unzigzag(codes: AnyCodes) -> AnyCodes:
    """Undo `_zigzag`, modulo the size of the type."""
    one = codes.dtype.type(1)
    signs: AnyCodes = codes & one
    np.negative(signs, out=signs)
    signs ^= codes >> one
    return signs
