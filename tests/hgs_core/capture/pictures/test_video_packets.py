"""A file's facts about its pictures: the shape of pixels, fields, and time stamps."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.pictures.video_packets import VideoPackets


def write(
    path: Path,
    *,
    codec: str = "libx264",
    aspect: Fraction | None = None,
    options: dict[str, str] | None = None,
    stamps: list[int] | None = None,
    tags: dict[str, str] | None = None,
) -> Path:
    with av.open(str(path), "w") as container:
        container.metadata.update(tags or {})
        stream = cast("av.VideoStream", container.add_stream(codec, rate=30, options=options or {}))
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        if aspect is not None:
            stream.codec_context.sample_aspect_ratio = aspect
        if stamps is not None:
            stream.codec_context.time_base = Fraction(1, 1000)
        for index in range(6):
            ramp = np.broadcast_to(np.arange(0, 256, 4, dtype=np.uint8)[None, :, None], (48, 64, 3))
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(ramp), format="rgb24")
            if stamps is not None:
                frame.pts, frame.time_base = stamps[index], Fraction(1, 1000)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


@pytest.mark.parametrize(
    ("ending", "codec", "options"),
    [
        ("mp4", "libx264", {"flags": "+ilme+ildct", "x264-params": "tff=1"}),
        ("mkv", "libx264", {"flags": "+ilme+ildct", "x264-params": "bff=1"}),
        ("ts", "libx264", {"flags": "+ilme+ildct", "x264-params": "tff=1"}),
        ("mpg", "mpeg2video", {"flags": "+ilme+ildct"}),
    ],
)
def test_fields_are_noticed(tmp_path: Path, ending: str, codec: str, options: dict[str, str]) -> None:
    assert VideoPackets.of(write(tmp_path / f"a.{ending}", codec=codec, options=options)).interlaced
    assert not VideoPackets.of(write(tmp_path / f"b.{ending}", codec=codec)).interlaced


@pytest.mark.parametrize("ending", ["mov", "mkv", "mxf"])
def test_time_codes_of_every_container_are_read(tmp_path: Path, ending: str) -> None:
    codec = "mpeg2video" if ending == "mxf" else "libx264"
    path = write(tmp_path / f"a.{ending}", codec=codec, tags={"timecode": "10:00:00:02"})
    assert VideoPackets.of(path).timecode == "10:00:00:02"


@pytest.mark.parametrize(
    ("aspect", "size"),
    [(Fraction(4, 3), (85, 48)), (Fraction(3, 4), (64, 64)), (None, (64, 48)), (Fraction(1), (64, 48))],
)
def test_pixels_are_made_square_on_request(tmp_path: Path, aspect: Fraction | None, size: tuple[int, int]) -> None:
    reader = VideoReader(write(tmp_path / "a.mp4", aspect=aspect))
    assert (reader.width, reader.height) == (64, 48)
    assert reader.read(0, 0)[0].shape == (48, 64, 3)
    assert reader.square_size == size
    square = VideoReader(tmp_path / "a.mp4", square=True)
    assert (square.width, square.height) == size
    shown = square.read(3, 0)[0]
    assert shown.shape == (size[1], size[0], 3)
    assert square.lines(3).shape == (48, 64)
    expected = (np.arange(size[0]) + 0.5) * 256 / size[0] - 2
    assert np.abs(shown[size[1] // 2, 4:-4, 1] - expected[4:-4]).max() < 8
    assert square.notes == (
        [] if size == (64, 48) else [f"pixels of {aspect} are stretched to {size[0]}x{size[1]} square ones"]
    )


def test_frames_of_one_moment_are_refused_with_a_command(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mkv", stamps=[0, 33, 67, 100, 133, 167], options={"bf": "0"})
    assert VideoPackets.of(path).stamps == [0, 33, 67, 100, 133, 167]
    path = write(tmp_path / "b.mkv", stamps=[0, 33, 33, 100, 133, 167], options={"bf": "0"})
    with pytest.raises(InputError, match=r"two frames have the same time stamp; .*ffmpeg -i b\.mkv .* && rm b\.mkv"):
        VideoPackets.of(path)


def test_a_missing_video_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"a\.mp4: the video is missing"):
        VideoPackets.of(tmp_path / "a.mp4")


def test_pixels_that_no_camera_has_are_taken_to_be_square(tmp_path: Path) -> None:
    reader = VideoReader(write(tmp_path / "a.mp4", aspect=Fraction(8, 1)), square=True)
    assert (reader.width, reader.height) == (64, 48)
    assert reader.notes == ["pixels of 8 are no camera's, and taken to be square"]
