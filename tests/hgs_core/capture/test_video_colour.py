"""Colours of videos with chroma of half the resolution, against the encoded pictures."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import numpy.typing as npt
import pytest

from hgs_core.capture.pictures.video import VideoReader

MATRICES = {"bt601": (0.299, 0.114, 5), "bt709": (0.2126, 0.0722, 1)}  # red and blue shares of luma, number in the file


@pytest.fixture
def truth(sample: Path) -> npt.NDArray[np.uint8]:
    return VideoReader(sample / "cam04.mp4").read(0, 0)[0]


def planes(picture: npt.NDArray[np.uint8], matrix: str, bits: int, full: bool) -> list[npt.NDArray[np.float64]]:
    """Return Y, U and V of 4:2:0; chroma stands between two lines and on every second column, as in H.264 and HEVC."""
    kr, kb, _ = MATRICES[matrix]
    rgb = picture / 255.0
    y = rgb @ np.array([kr, 1 - kr - kb, kb])
    step = float(1 << (bits - 8))
    scale = (0.0, float((1 << bits) - 1), float((1 << bits) - 1)) if full else (16 * step, 219 * step, 224 * step)
    result = [scale[0] + scale[1] * y]
    for channel, weight in ((2, kb), (0, kr)):
        chroma = np.pad((rgb[..., channel] - y) / (2 * (1 - weight)), ((0, 0), (1, 1)), "edge")
        columns = (chroma[:, :-2] + 2 * chroma[:, 1:-1] + chroma[:, 2:])[:, ::2] / 4
        result.append(128 * step + scale[2] * (columns[::2] + columns[1::2]) / 2)
    return [np.clip(np.rint(plane), 0, (1 << bits) - 1) for plane in result]


def encode(path: Path, picture: npt.NDArray[np.uint8], matrix: str, bits: int, full: bool) -> None:
    pixels = "yuv420p" if bits == 8 else "yuv420p10le"
    frame = av.VideoFrame(picture.shape[1], picture.shape[0], pixels)
    for plane, values in zip(frame.planes, planes(picture, matrix, bits, full), strict=True):
        rows = np.zeros((plane.height, plane.line_size), np.uint8)
        data = values.astype(np.uint8 if bits == 8 else "<u2").view(np.uint8)
        rows[:, : data.shape[1]] = data
        plane.update(rows.tobytes())
    with av.open(str(path), "w") as container:
        # FFmpeg now and then writes no MP4 of x265's streams.
        stream = container.add_stream("libx264", rate=30, options={"crf": "1"} if bits == 8 else {"qp": "1"})
        stream.width, stream.height, stream.pix_fmt = frame.width, frame.height, pixels
        stream.codec_context.colorspace = frame.colorspace = MATRICES[matrix][2]
        stream.codec_context.color_range = frame.color_range = 2 if full else 1
        container.mux(stream.encode(frame))
        container.mux(stream.encode())


@pytest.mark.parametrize(
    ("matrix", "bits", "full"),
    [("bt601", 8, False), ("bt709", 8, False), ("bt709", 8, True), ("bt601", 10, False), ("bt709", 10, False)],
)
def test_chroma_is_interpolated_where_it_stands_and_rounded(
    truth: npt.NDArray[np.uint8], tmp_path: Path, matrix: str, bits: int, full: bool
) -> None:
    encode(tmp_path / "cam00.mp4", truth, matrix, bits, full)
    error = VideoReader(tmp_path / "cam00.mp4").read(0, 0)[0].astype(float) - truth
    assert 10 * np.log10(255**2 / (error**2).mean()) > 34.0  # chroma that is repeated and cut off gives 31 to 32
    assert abs(error.mean()) < 0.15  # it gives a level too little, or two


def test_full_chroma_comes_through_as_it_always_did(sample: Path) -> None:
    with av.open(str(sample / "cam09.mp4")) as container:
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)][:4]
    reader = VideoReader(sample / "cam09.mp4")
    for index, frame in enumerate(frames):
        np.testing.assert_array_equal(reader.read(index, 0)[0], frame)
