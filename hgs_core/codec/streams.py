"""From integer codes to the bytes of a stream and back: transforms, byte planes, one zstd frame.

A stream of C components of b bits holds, for each component, ceil(b / 8) planes of N bytes, low byte first.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
import zstandard
from numpy.typing import NDArray

__all__ = ["Transform", "compress", "decompress", "from_planes", "to_planes", "transform", "undo_transform"]

Codes = NDArray[np.uint32]  # [N, C]


class Transform(IntEnum):
    """What is done to the codes before they are split into planes; differences are modulo 2^bits, then zigzag."""

    NONE = 0
    DELTA = 1  # each splat minus the one before it (the first minus zero), per component
    GREEN = 2  # (r, g, b) becomes (g, r - g, b - g)


def transform(codes: Codes, bits: int, kind: Transform) -> Codes:
    """Apply a transform."""
    if kind == Transform.DELTA:
        before = np.concatenate([np.zeros((1, codes.shape[1]), np.uint32), codes[:-1]])
        return _zigzag(codes - before, bits)
    if kind == Transform.GREEN:
        green = codes[:, 1:2]
        return np.concatenate([green, _zigzag(codes[:, [0, 2]] - green, bits)], axis=1)
    return codes


def undo_transform(codes: Codes, bits: int, kind: Transform) -> Codes:
    """Undo `transform`."""
    mask = np.uint32((1 << bits) - 1)
    if kind == Transform.DELTA:
        return np.cumsum(_unzigzag(codes), axis=0, dtype=np.uint32) & mask
    if kind == Transform.GREEN:
        green = codes[:, :1]
        others = (_unzigzag(codes[:, 1:]) + green) & mask
        return np.concatenate([others[:, :1], green, others[:, 1:]], axis=1)
    return codes


def to_planes(codes: Codes, bits: int) -> bytes:
    """Split codes below 2^bits into byte planes."""
    planes = [codes[:, c] >> np.uint32(8 * p) for c in range(codes.shape[1]) for p in range((bits + 7) // 8)]
    return np.stack(planes).astype(np.uint8).tobytes()


def from_planes(raw: bytes, count: int, components: int, bits: int) -> Codes:
    """Join byte planes into codes [count, components]; `raw` has the exact length."""
    planes = np.frombuffer(raw, np.uint8).reshape(components, (bits + 7) // 8, count)
    codes = np.zeros((components, count), np.uint32)
    for p in range(planes.shape[1]):
        codes |= planes[:, p].astype(np.uint32) << np.uint32(8 * p)
    return np.ascontiguousarray(codes.T)


def compress(raw: bytes, level: int) -> bytes:
    """Return one zstd frame that states its content size."""
    return zstandard.ZstdCompressor(level=level, write_checksum=False, write_content_size=True).compress(raw)


def decompress(frame: bytes, length: int) -> bytes:
    """Return the content of one zstd frame of exactly `length` bytes; no more than that is ever allocated.

    Raises:
        ValueError: it is not one whole frame with that content size.
    """
    try:
        stated = zstandard.get_frame_parameters(frame).content_size
        if stated != length:
            raise ValueError(f"a frame of {stated} bytes")
        raw = zstandard.ZstdDecompressor().decompress(frame, max_output_size=length, allow_extra_data=False)
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


def _unzigzag(codes: Codes) -> Codes:
    """Undo `_zigzag`, modulo 2^32."""
    return codes >> np.uint32(1) ^ (np.uint32(0) - (codes & np.uint32(1)))
