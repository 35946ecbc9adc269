from __future__ import annotations

import io

import av
import numpy as np
import pytest

from hgs_core.capture.sound.aac_packets import AAC_SAMPLES, AacHeader


@pytest.fixture(scope="module")
def encoded() -> tuple[bytes, list[bytes]]:
    """The AudioSpecificConfig and the packets of a second of stereo noise at 44.1 kHz, by FFmpeg's encoder."""
    encoder = av.CodecContext.create("aac", "w")
    encoder.sample_rate, encoder.layout, encoder.format = 44_100, "stereo", "fltp"
    made = []
    for number in range(43):
        noise = np.random.default_rng(number).normal(size=(2, AAC_SAMPLES)).astype(np.float32) * 0.1
        frame = av.AudioFrame.from_ndarray(noise, format="fltp", layout="stereo")
        frame.sample_rate, frame.pts = 44_100, number * AAC_SAMPLES
        made += [bytes(packet) for packet in encoder.encode(frame)]
    return bytes(encoder.extradata or b""), made


def test_ffmpeg_reads_the_packets_back(encoded: tuple[bytes, list[bytes]]) -> None:
    config, packets = encoded
    header = AacHeader.of(config, packets[0])
    assert header is not None
    assert (header.rate, header.channels) == (44_100, 2)
    with av.open(io.BytesIO(b"".join(map(header.packed, packets)))) as container:
        assert container.format.name == "aac"
        frames = list(container.decode(audio=0))
    assert (len(frames), frames[0].sample_rate, frames[0].layout.name) == (len(packets), 44_100, "stereo")


def test_packets_with_headers_of_their_own_stay_as_they_are(encoded: tuple[bytes, list[bytes]]) -> None:
    config, packets = encoded
    given = AacHeader.of(config, packets[0])
    assert given is not None
    headed = given.packed(packets[3])
    header = AacHeader.of(b"", headed)
    assert header is not None
    assert (header.rate, header.channels, header.packed(headed)) == (44_100, 2, headed)


@pytest.mark.parametrize("config", [bytes([0x2B, 0x11]), bytes([0x11, 0xB0]), b""], ids=["HE", "six-channels", "none"])
def test_what_is_not_plain_stereo_has_no_header(config: bytes) -> None:
    assert AacHeader.of(config, bytes(100)) is None
