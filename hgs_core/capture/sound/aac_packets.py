"""AAC packets with ADTS headers (ISO 14496-3, 1.A): a stream that browsers decode by itself."""

from __future__ import annotations

__all__ = ["AAC_SAMPLES", "AacHeader"]

AAC_SAMPLES = 1024
"""Samples of a packet, per channel."""

_RATES = (96000, 88200, 64000, 48000, 44100, 32000, 24000, 22050, 16000, 12000, 11025, 8000, 7350)
_LOW_COMPLEXITY = 2
_LONGEST = (1 << 13) - 1  # bytes of a packet with its header
_HEADER_BYTES = 7


class AacHeader:
    """The header before each packet of a stream."""

    def __init__(self, rate_index: int, channels: int, headed: bool) -> None:
        self._rate_index, self._headed = rate_index, headed
        self.rate = _RATES[rate_index]  # samples per second
        self.channels = channels

    @classmethod
    def of(cls, config: bytes, packet: bytes) -> AacHeader | None:
        """Return the header for packets of a stream with this AudioSpecificConfig.

        Without a config the packets have their own ADTS headers. None for anything but mono or stereo of low
        complexity.
        """
        headed = len(config) < 2
        if not headed:
            kind, rate, channels = config[0] >> 3, (config[0] & 7) << 1 | config[1] >> 7, config[1] >> 3 & 15
        elif _has_header(packet):
            kind, rate = (packet[2] >> 6) + 1, packet[2] >> 2 & 15
            channels = (packet[2] & 1) << 2 | packet[3] >> 6
        else:
            return None
        fits = kind == _LOW_COMPLEXITY and rate < len(_RATES) and channels in (1, 2)
        return cls(rate, channels, headed) if fits else None

    def packed(self, packet: bytes) -> bytes:
        """Return a packet behind its header; one that came with a header stays as it is.

        Raises:
            ValueError: the packet is longer than a header can say.
        """
        if self._headed:
            return packet
        length = len(packet) + _HEADER_BYTES
        if length > _LONGEST:
            raise ValueError(f"a packet of {len(packet)} bytes")
        bits = 0xFFF1 << 40 | (_LOW_COMPLEXITY - 1) << 38 | self._rate_index << 34 | self.channels << 30
        bits |= length << 13 | 0x7FF << 2  # unknown buffer fullness, one block
        return bits.to_bytes(_HEADER_BYTES, "big") + packet


def _has_header(packet: bytes) -> bool:
    return len(packet) > _HEADER_BYTES and packet[0] == 0xFF and packet[1] & 0xF6 == 0xF0
