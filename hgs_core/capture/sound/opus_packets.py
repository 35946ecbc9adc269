"""Opus packets in Ogg pages (RFC 3533, RFC 7845): a small file that browsers decode by itself.

Written here rather than by FFmpeg, whose bytes change with its version and from run to run: pieces of sound are named
by their content.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator, Sequence

__all__ = ["OPUS_RATE", "ogg_opus", "opus_head", "opus_samples"]

OPUS_RATE = 48_000
"""Samples per second in which Opus counts, at any recorded rate."""

_SERIAL = 1  # the only stream in a file
_FIRST, _LAST = 2, 4  # flags of pages
_MOST_SEGMENTS = 255  # segments of a page
_HEAD = struct.Struct("<8sBBHIhB")  # magic, version, channels, pre-skip, rate, gain, family of the channels' mapping
_FRAME_SAMPLES = (
    (480, 960, 1920, 2880) * 3 + (480, 960) * 2 + (120, 240, 480, 960) * 4
)  # indexed with the configuration (RFC 6716)
_REVERSED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def opus_samples(packet: bytes) -> int:
    """Return how many samples, of `OPUS_RATE`, a packet decodes to."""
    code = packet[0] & 3
    frames = (1, 2, 2)[code] if code < 3 else packet[1] & 63
    return _FRAME_SAMPLES[packet[0] >> 3] * frames


def opus_head(channels: int, rate: int = OPUS_RATE, gain: int = 0) -> bytes:
    """Return the header of mono or stereo, without samples to skip; `rate` is the recorded rate."""
    return _HEAD.pack(b"OpusHead", 1, channels, 0, rate, gain, 0)


def ogg_opus(head: bytes, packets: Sequence[bytes]) -> bytes:
    """Return an Ogg file of packets; all samples count. Equal arguments give equal bytes."""
    tags = b"OpusTags" + struct.pack("<I", 0) + struct.pack("<I", 0)
    pages = [_page(_FIRST, 0, 0, [head]), _page(0, 0, 1, [tags])]
    samples = 0
    groups = list(_groups(packets))
    for number, group in enumerate(groups):
        samples += sum(opus_samples(packet) for packet in group)
        pages.append(_page(_LAST if number == len(groups) - 1 else 0, samples, number + 2, group))
    return b"".join(pages)


def _groups(packets: Sequence[bytes]) -> Iterator[list[bytes]]:
    """Yield the packets of each page, none of which spans two."""
    group: list[bytes] = []
    segments = 0
    for packet in packets:
        own = len(packet) // 255 + 1
        if segments + own > _MOST_SEGMENTS:
            yield group
            group, segments = [], 0
        group.append(packet)
        segments += own
    yield group


def _page(flags: int, samples: int, number: int, packets: Sequence[bytes]) -> bytes:
    lacing = b"".join(b"\xff" * (len(packet) // 255) + bytes([len(packet) % 255]) for packet in packets)
    head = struct.pack("<4sBBQIII", b"OggS", 0, flags, samples, _SERIAL, number, 0) + bytes([len(lacing)]) + lacing
    page = head + b"".join(packets)
    return page[:22] + struct.pack("<I", _checksum(page)) + page[26:]


def _checksum(page: bytes) -> int:
    """Return the CRC of a page: that of zlib with all bits the other way round, and nothing inverted."""
    mirrored = zlib.crc32(page.translate(_REVERSED), 0xFFFFFFFF) ^ 0xFFFFFFFF
    return int(f"{mirrored:032b}"[::-1], 2)
