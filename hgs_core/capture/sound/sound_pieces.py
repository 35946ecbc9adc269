"""The sound of a file in pieces of about a second, as it came where browsers decode it, else as Opus.

Each piece is a file of its own: Ogg for Opus, ADTS for AAC, which `decodeAudioData` of browsers takes, without the
headers that an MP4 would repeat in each. A decoder needs some packets before the first one that counts; they stand
before it, so that the last sample of a piece, and not its first, belongs to a known time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import open_container
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.sound.aac_packets import AAC_SAMPLES, AacHeader
from hgs_core.capture.sound.opus_packets import OPUS_RATE, ogg_opus, opus_head, opus_samples

if TYPE_CHECKING:
    import av

__all__ = ["PIECE_SECONDS", "CutSound", "SoundPiece", "cut_sound"]

PIECE_SECONDS = 1.0
"""At least so long is a piece, but for one at a hole: a request costs more than it brings."""

_LEAD = {"opus": 0.12, "aac": 0.04}  # seconds that a decoder needs to find its state: RFC 7845 and half; two packets
_BITS_PER_CHANNEL = 64_000  # bits per second
_HOLE = 0.5  # share of a packet's length; a longer gap begins a new piece
_ROUNDED = 0.008  # seconds by which stamps may miss the end of the packet before, and still mean it
_HEAD_BYTES = 19


@dataclass(frozen=True)
class SoundPiece:
    """A stretch of sound, and a file of it; decoded samples before its first one may belong to others."""

    start: float  # seconds
    end: float
    data: bytes


@dataclass(frozen=True)
class CutSound:
    """Sound in pieces, in order of time."""

    codec: str  # "opus" or "aac"
    sample_rate: int
    channels: int  # 1 or 2
    pieces: tuple[SoundPiece, ...]
    encoded_from: str = ""  # the codec that it came in, if another


@dataclass(frozen=True)
class _Packet:
    time: float  # first sample, seconds
    length: float  # seconds
    data: bytes


def cut_sound(path: Path, start: float, end: float, offset: float = 0.0) -> CutSound | None:
    """Return the first sound track of a file from `start` to `end`, to whole packets; None if there is none then.

    `offset` is added to the file's own times; pieces have the times of the sum, seconds.

    Raises:
        InputError: the file is missing or its sound is damaged.
    """
    import av

    try:
        with open_container(path) as container:
            if not container.streams.audio:
                return None
            stream = container.streams.audio[0]
            packets = [packet for packet in container.demux(stream) if packet.size and packet.pts is not None]
            copied = _copied(stream, packets, offset)
        return copied.between(start, end) if copied else _encoded(path, start, end, offset)
    except InputError:
        raise
    except (av.FFmpegError, OSError, ValueError) as error:
        raise unreadable(path, error, "export it again, or use --audio none", "the sound is unreadable") from error


@dataclass(frozen=True)
class _Track:
    codec: str
    sample_rate: int
    channels: int
    packets: Sequence[_Packet]
    head: bytes = b""  # Opus header
    encoded_from: str = ""

    def between(self, start: float, end: float) -> CutSound | None:
        """Cut out the packets that sound from `start` to `end`, seconds."""
        inside = [i for i, one in enumerate(self.packets) if one.time + one.length > start and one.time < end]
        pieces = tuple(self._piece(group) for group in _groups(self.packets, inside))
        return CutSound(self.codec, self.sample_rate, self.channels, pieces, self.encoded_from) if pieces else None

    def _piece(self, group: range) -> SoundPiece:
        packets = self.packets
        begin, own = packets[group.start].time, sum(packets[i].length for i in group)
        first = group.start
        while first > 0 and packets[first].time > begin - _LEAD[self.codec] + 1e-6:
            first -= 1
        data = [packets[i].data for i in range(first, group.stop)]
        begin, end = round(begin, 6), round(begin + own, 6)  # microseconds, or manifests grow by digits
        return SoundPiece(begin, end, ogg_opus(self.head, data) if self.head else b"".join(data))


def _groups(packets: Sequence[_Packet], inside: Sequence[int]) -> Iterator[range]:
    """Yield the packets of each piece."""
    if not inside:
        return
    first, stop = inside[0], inside[-1] + 1
    for i in inside[1:]:
        before = packets[i - 1]
        until = before.time + before.length
        hole = abs(packets[i].time - until) > _HOLE * before.length
        short = packets[stop - 1].time - until < PIECE_SECONDS / 2  # the rest joins the last piece
        if hole or (until - packets[first].time >= PIECE_SECONDS - 1e-6 and not short):
            yield range(first, i)
            first = i
    yield range(first, stop)


def _copied(stream: av.AudioStream, packets: Sequence[av.Packet[Any]], offset: float) -> _Track | None:
    """Return the packets as they came; None if browsers do not decode them so."""
    name, config = stream.codec_context.name, bytes(stream.codec_context.extradata or b"")
    if not packets or stream.time_base is None:
        return None
    stamps = [float(packet.pts * stream.time_base) + offset for packet in packets if packet.pts is not None]
    if name.startswith(("opus", "libopus")) and len(config) >= _HEAD_BYTES and config[18] == 0 and config[9] in (1, 2):
        head = config[:10] + bytes(2) + config[12:_HEAD_BYTES]  # nothing is skipped
        datas = [bytes(packet) for packet in packets]
        found = _in_a_row(stamps, [opus_samples(data) / OPUS_RATE for data in datas], datas)
        return _Track("opus", OPUS_RATE, config[9], found, head)
    header = AacHeader.of(config, bytes(packets[0])) if name == "aac" else None
    if header is None:
        return None
    lengths = [AAC_SAMPLES / header.rate] * len(packets)
    found = _in_a_row(stamps, lengths, [header.packed(bytes(packet)) for packet in packets])
    return _Track("aac", header.rate, header.channels, found)


def _in_a_row(stamps: Sequence[float], lengths: Sequence[float], datas: Sequence[bytes]) -> list[_Packet]:
    """Return packets that follow each other to the sample where their stamps are only rounded, to 1 ms in Matroska."""
    found: list[_Packet] = []
    for stamp, length, data in zip(stamps, lengths, datas, strict=True):
        expected = found[-1].time + found[-1].length if found else stamp
        found.append(_Packet(expected if abs(stamp - expected) < _ROUNDED else stamp, length, data))
    return found


def _encoded(path: Path, start: float, end: float, offset: float) -> CutSound | None:
    """Encode sound that browsers do not decode, as Opus.

    Raises:
        InputError: this FFmpeg has no encoder for Opus.
    """
    import av

    with open_container(path) as container:
        stream = container.streams.audio[0]
        name, channels = stream.codec_context.name, min(2, stream.codec_context.channels or 1)
        try:
            encoder: Any = av.CodecContext.create("libopus", "w")
        except (av.FFmpegError, ValueError) as error:
            cure = "convert it to Opus or AAC, or use --audio none"
            raise InputError(path, f"the sound is {name}, and PyAV has no encoder for Opus here", cure) from error
        layout = "mono" if channels == 1 else "stereo"
        encoder.sample_rate, encoder.layout, encoder.format = OPUS_RATE, layout, "s16"
        encoder.bit_rate = _BITS_PER_CHANNEL * channels
        resampler = av.AudioResampler(format="s16", layout=layout, rate=OPUS_RATE, frame_size=OPUS_RATE // 50)
        found: list[av.Packet[Any]] = []
        first: float | None = None
        samples = 0

        def encode(parts: Sequence[av.AudioFrame]) -> None:
            nonlocal samples
            for part in parts:
                part.pts, samples = samples, samples + part.samples
                found.extend(encoder.encode(part))

        for frame in container.decode(stream):
            time = float(frame.time or 0.0) + offset
            length = frame.samples / frame.sample_rate
            if time + length <= start - PIECE_SECONDS:
                continue
            if time >= end + PIECE_SECONDS:
                break
            first = time if first is None else first
            encode(resampler.resample(frame))
        if first is None:
            return None
        encode(resampler.resample(None))
        found.extend(encoder.encode(None))
    packets = [
        _Packet(first + packet.pts / OPUS_RATE, opus_samples(bytes(packet)) / OPUS_RATE, bytes(packet))
        for packet in found
        if packet.size and packet.pts is not None
    ]
    head = opus_head(channels)
    return _Track("opus", OPUS_RATE, channels, packets, head, encoded_from=name).between(start, end)
