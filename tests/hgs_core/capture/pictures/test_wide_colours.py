"""Against values that BT.2100 and BT.2408 print, and videos tagged as phones tag them."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest

from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.pictures.wide_colours import WideColours

PQ, HLG, BT2020 = 16, 18, 9


def grey(signal: float) -> np.ndarray:
    return np.full((1, 1, 3), round(65535 * signal), np.uint16)


def test_diffuse_white_is_one_level_in_both_curves() -> None:
    """BT.2408: 203 cd/m2 is 58 % of PQ and 75 % of HLG."""
    pq, hlg = WideColours(PQ, BT2020).shown(grey(0.5807)), WideColours(HLG, BT2020).shown(grey(0.75))
    assert np.abs(pq.astype(int) - hlg).max() <= 1
    assert 220 < int(pq[0, 0, 1]) < 240  # the rest is for highlights


@pytest.mark.parametrize(("signal", "nits"), [(0.3023, 10.0), (0.5081, 100.0)])
def test_what_is_darker_is_not_compressed(signal: float, nits: float) -> None:
    """BT.2408's table of PQ: 10 and 100 cd/m2 are 30 % and 51 % of the signal."""
    expected = 255 * (nits / 203) ** (1 / 2.4)
    np.testing.assert_allclose(WideColours(PQ, BT2020).shown(grey(signal)), expected, atol=2.5)


def test_highlights_stay_apart_up_to_a_thousand_candelas() -> None:
    levels = [int(WideColours(PQ, BT2020).shown(grey(signal))[0, 0, 0]) for signal in (0.58, 0.65, 0.75, 0.9)]
    assert levels[0] < levels[1] < levels[2] == levels[3] == 255


def test_a_colour_of_bt709_comes_back_from_bt2020() -> None:
    """BT.2087's matrix, the other way round."""
    to_bt2020 = np.array([[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.088, 0.8956]])
    wanted = np.array([200.0, 60.0, 30.0])
    signal = (to_bt2020 @ (wanted / 255) ** 2.4) ** (1 / 2.4)
    picture = np.round(65535 * signal).astype(np.uint16)[None, None]
    np.testing.assert_allclose(WideColours(14, BT2020).shown(picture)[0, 0], wanted, atol=1)


@pytest.mark.parametrize(("transfer", "primaries", "name"), [(PQ, 9, "HDR (PQ)"), (HLG, 9, "HDR (HLG)"), (1, 1, None)])
def test_videos_are_read_as_their_tags_say(tmp_path: Path, transfer: int, primaries: int, name: str | None) -> None:
    with av.open(str(tmp_path / "a.mp4"), "w") as container:
        stream = container.add_stream("libx264", rate=30)  # FFmpeg now and then writes no MP4 of x265's streams
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p10le"
        context = stream.codec_context
        context.color_trc, context.color_primaries, context.colorspace = transfer, primaries, primaries
        given = av.VideoFrame.from_ndarray(np.full((48, 64, 3), round(0.75 * 65535), np.uint16), format="rgb48le")
        frame = given.reformat(format="yuv420p10le", dst_colorspace=primaries)
        frame.color_trc, frame.color_primaries, frame.colorspace = transfer, primaries, primaries
        frame.pts = 0
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    video = VideoReader(tmp_path / "a.mp4")
    assert (video.wide_colours.name if video.wide_colours else None) == name
    level = int(video.read(0, 0)[0][24, 32, 1])
    assert level == pytest.approx({PQ: 255, HLG: 230, 1: 191}[transfer], abs=2)
