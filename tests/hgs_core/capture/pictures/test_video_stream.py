"""Of several streams the camera's is read, and none is guessed."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import cast

import av
import numpy as np
import pytest
from av.stream import Disposition

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import open_container
from hgs_core.capture.pictures.announced_length import announced_length
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.pictures.video_stream import stated_rate, video_stream
from hgs_core.capture.sound.sound_track import sound_begin


def write_streams(path: Path, streams: Sequence[tuple[tuple[int, int], int]]) -> Path:
    """Write streams of sizes and numbers of frames; those of the last one are of level 100."""
    with av.open(str(path), "w") as container:
        made = []
        for (width, height), _ in streams:
            stream = container.add_stream("libx264", rate=30, options={"bf": "0", "crf": "1"})
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            made.append(stream)
        for index, ((width, height), frames) in enumerate(streams):
            grey = np.full((height, width, 3), 100 if index == len(streams) - 1 else 200, np.uint8)
            for _ in range(frames):
                container.mux(made[index].encode(av.VideoFrame.from_ndarray(grey, format="rgb24")))
            container.mux(made[index].encode())
    return path


@pytest.mark.parametrize("ending", ["mp4", "mkv"])
@pytest.mark.parametrize("thumbnails", [1, 2])
def test_a_thumbnail_track_before_the_video_is_left_out_and_said(tmp_path: Path, ending: str, thumbnails: int) -> None:
    path = write_streams(tmp_path / f"a.{ending}", [((32, 32), thumbnails), ((64, 48), 12)])
    reader = VideoReader(path)
    assert (reader.width, reader.height, len(reader)) == (64, 48, 12)
    assert abs(int(reader.read(7, 0)[0].mean()) - 100) < 4
    assert reader.notes == ["of its 2 video streams the longest is read: 64x48, 12 frames"]
    assert announced_length(path).rate == 30
    assert sound_begin(path) == 0


def test_a_cover_of_a_song_is_no_video(tmp_path: Path) -> None:
    path = tmp_path / "a.mp3"
    with av.open(str(path), "w") as container:
        sound = container.add_stream("libmp3lame", rate=48_000, layout="mono")
        cover = container.add_stream("png")
        cover.width, cover.height, cover.pix_fmt, cover.time_base = 32, 32, "rgb24", Fraction(1, 90_000)
        cover.disposition = Disposition.attached_pic
        container.mux(cover.encode(av.VideoFrame(32, 32, "rgb24")))
        for start in range(0, 48_000, 1152):
            frame = av.AudioFrame.from_ndarray(np.zeros((1, 1152), np.float32), format="fltp", layout="mono")
            frame.sample_rate, frame.pts = 48_000, start
            container.mux(sound.encode(frame))
        container.mux(sound.encode())
    with open_container(path) as opened:
        assert len(opened.streams.video) == 1
        assert video_stream(path, opened) == (None, "")


@pytest.mark.parametrize("sizes", [[(32, 32), (64, 48)], [(64, 48), (64, 48), (64, 48)]])
def test_several_long_streams_are_listed_and_refused(tmp_path: Path, sizes: list[tuple[int, int]]) -> None:
    path = write_streams(tmp_path / "a.mp4", [(size, 10 + place) for place, size in enumerate(sizes)])
    with pytest.raises(InputError, match=rf"{len(sizes)} video streams, .*: 0:0 of .*, 10 frames, 0:1 of 64x48, 11"):
        VideoReader(path)
    with pytest.raises(InputError, match=rf"ffmpeg -i a\.mp4 -map 0:{len(sizes) - 1} -c copy new\.mp4 && mv new"):
        announced_length(path)


def test_no_stream_of_pictures_is_none(tmp_path: Path) -> None:
    path = tmp_path / "a.m4a"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("aac", rate=48_000, layout="mono")
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), format="fltp", layout="mono")
        frame.sample_rate = 48_000
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    with open_container(path) as opened:
        assert video_stream(path, opened) == (None, "")


@pytest.mark.parametrize(
    ("ending", "codec", "rate"),
    [
        ("h264", "libx264", Fraction(30)),
        ("h264", "libx264", Fraction(30000, 1001)),
        ("hevc", "libx265", Fraction(50)),
        ("m2v", "mpeg2video", Fraction(24)),
        ("mp4", "libx264", Fraction(60)),
        ("ivf", "libvpx", Fraction(30)),
        ("avi", "mpeg4", Fraction(12)),
    ],
)
def test_the_rate_is_the_file_s_own(tmp_path: Path, ending: str, codec: str, rate: Fraction) -> None:
    path = tmp_path / f"a.{ending}"
    forced = {"m2v": "mpeg2video"}.get(ending, ending)
    options = {"x265-params": "log-level=none"} if codec == "libx265" else {}
    with av.open(str(path), "w", format=forced) as container:
        stream = cast("av.VideoStream", container.add_stream(codec, rate=rate, options=options))
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for level in range(10, 130, 10):
            grey = np.full((48, 64, 3), level, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(grey, format="rgb24")))
        container.mux(stream.encode())
    with open_container(path) as opened:
        assert stated_rate(opened, opened.streams.video[0]) == rate
    reader = VideoReader(path)
    np.testing.assert_allclose(reader.seconds - reader.seconds[0], np.arange(12) / float(rate), atol=1e-6)
    assert any("its stream says" in note for note in reader.notes) == (ending in ("h264", "hevc", "m2v"))


def test_a_bare_stream_that_states_no_rate_is_refused_with_a_command_that_gives_it_one(tmp_path: Path) -> None:
    path = tmp_path / "a.mjpeg"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuvj420p"
        for _ in range(5):
            container.mux(stream.encode(av.VideoFrame(64, 48, "yuvj420p")))
        container.mux(stream.encode())
    with pytest.raises(InputError, match=r"does not state its frames per second; .*ffmpeg -framerate 30 -i a\.mjpeg"):
        VideoReader(path)
