from __future__ import annotations

import io

import av
import numpy as np
import pytest

from hgs_core.capture.sound.opus_packets import OPUS_RATE, ogg_opus, opus_head, opus_samples


@pytest.fixture(scope="module")
def packets() -> list[bytes]:
    """A second of noise, by FFmpeg's encoder."""
    encoder = av.CodecContext.create("libopus", "w")
    encoder.sample_rate, encoder.layout, encoder.format, encoder.bit_rate = OPUS_RATE, "stereo", "s16", 256_000
    made = []
    for number in range(50):
        noise = np.random.default_rng(number).integers(-9000, 9000, (1, 1920), np.int16)
        frame = av.AudioFrame.from_ndarray(noise, format="s16", layout="stereo")
        frame.sample_rate, frame.pts = OPUS_RATE, number * 960
        made += [bytes(packet) for packet in encoder.encode(frame)]
    return [packet for packet in made if packet]


def test_ffmpeg_reads_the_packets_back_and_decodes_all_their_samples(packets: list[bytes]) -> None:
    data = ogg_opus(opus_head(2), packets)
    with av.open(io.BytesIO(data)) as container:
        assert container.format.name == "ogg"
        assert [bytes(packet) for packet in container.demux(audio=0) if packet.size] == packets
    with av.open(io.BytesIO(data)) as container:
        samples = sum(frame.samples for frame in container.decode(audio=0))
    assert samples == 960 * len(packets) == sum(map(opus_samples, packets))


def test_equal_packets_give_equal_bytes(packets: list[bytes]) -> None:
    assert ogg_opus(opus_head(2), packets) == ogg_opus(opus_head(2), packets)


@pytest.mark.parametrize(
    ("packet", "milliseconds"),  # RFC 6716, table 2 and section 3.2
    [(b"\x00", 10), (b"\x18", 60), (b"\x60", 10), (b"\x80", 2.5), (b"\xf8", 20), (b"\xf9", 40), (b"\xfb\x03", 60)],
)
def test_a_packet_says_how_long_it_is(packet: bytes, milliseconds: float) -> None:
    assert opus_samples(packet) / OPUS_RATE == pytest.approx(milliseconds / 1000)
