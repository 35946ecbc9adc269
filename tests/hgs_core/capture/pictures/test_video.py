"""Random access to video frames, against frames with their number as grey level."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import av
import numpy as np
import pytest

from hgs_core.base.errors import InputError
from hgs_core.capture.pictures.video import VideoReader

VideoWriter = Callable[..., None]
LEVELS = [10 * i + 10 for i in range(20)]


@pytest.fixture
def video(tmp_path: Path, write_video: VideoWriter) -> Path:
    path = tmp_path / "cam00.mp4"
    write_video(path, LEVELS, gop=6)
    return path


def level(picture: np.ndarray) -> int:
    return 10 * round(float(picture.mean()) / 10)  # limited range costs a level


@pytest.mark.parametrize("order", [range(20), range(19, -1, -1), [0, 19, 7, 8, 6, 5, 18, 12, 12, 0]])
def test_every_order_of_access_gives_the_right_frames(video: Path, order: list[int]) -> None:
    reader = VideoReader(video)
    assert [level(reader.read(index, 0)[0]) for index in order] == [LEVELS[index] for index in order]


@pytest.mark.parametrize("ending", ["avi", "h264"])
def test_frames_without_a_time_of_their_own_come_in_the_decoder_s_order(tmp_path: Path, ending: str) -> None:
    """AVI tells when a packet is decoded, which with B-frames is another order; a bare stream tells nothing."""
    path = tmp_path / f"a.{ending}"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "10", "bf": "2"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        for value in LEVELS:
            picture = np.full((48, 64, 3), value, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())
    reader = VideoReader(path)
    assert [level(reader.read(index, 0)[0]) for index in (3, 4, 19, 0, 7)] == [
        LEVELS[index] for index in (3, 4, 19, 0, 7)
    ]
    np.testing.assert_allclose(np.diff(reader.seconds), 1 / reader.frame_rate, rtol=1e-6)


def test_frames_decoded_on_the_way_are_handed_over(video: Path) -> None:
    passed = VideoReader(video).read(5, 3)[1]
    assert [(index, level(picture)) for index, picture in passed] == [(i, LEVELS[i]) for i in (2, 3, 4)]


def test_forward_access_never_seeks(video: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reader = VideoReader(video)
    seeks = []
    seek = reader._seek
    monkeypatch.setattr(reader, "_seek", lambda key: (seeks.append(key), seek(key)))
    for index in range(20):
        reader.read(index, 0)
    assert seeks[:1] == [0]
    assert len(seeks) <= 4  # one for each key frame at most


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="no other system lists the open files of a process")
def test_the_file_is_open_until_the_last_frame_is_read(video: Path) -> None:
    reader = VideoReader(video)
    opened = []
    for index in (18, 19):
        reader.read(index, 0)
        opened.append(video in [path.resolve() for path in Path("/proc/self/fd").iterdir()])
    assert opened == [True, False]
    assert level(reader.read(19, 0)[0]) == LEVELS[19]


def test_colours_follow_the_colour_space_that_the_file_states(tmp_path: Path) -> None:
    path = tmp_path / "cam00.mp4"
    colour = np.full((48, 64, 3), (200, 60, 30), np.uint8)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "0"})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv444p"
        stream.codec_context.colorspace = 1  # BT.709
        frame = av.VideoFrame.from_ndarray(colour, format="rgb24")
        frame = frame.reformat(format="yuv444p", dst_colorspace="ITU709")
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    picture = VideoReader(path).read(0, 0)[0]
    assert np.abs(picture.astype(int) - colour).max() <= 3


@pytest.mark.parametrize(
    ("ending", "codec", "form"),
    [("mov", "png", "rgba"), ("mov", "prores_ks", "yuva444p10le"), ("webm", "vp9", "yuva420p")],
)
def test_what_is_transparent_is_black_or_the_note_has_the_command(
    tmp_path: Path, ending: str, codec: str, form: str
) -> None:
    path = tmp_path / f"a.{ending}"
    picture = np.full((48, 64, 4), (200, 60, 30, 255), np.uint8)
    picture[:, 32:, 3] = 0
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libvpx-vp9" if codec == "vp9" else codec, rate=30)
        stream.width, stream.height, stream.pix_fmt = 64, 48, form
        stream.metadata["alpha_mode"] = "1"
        container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgba").reformat(format=form)))
        container.mux(stream.encode())
    reader = VideoReader(path)
    read = reader.read(0, 0)[0].astype(int)
    assert np.abs(read[:, 4:28] - (200, 60, 30)).max() <= 8
    if codec == "vp9":
        assert any("ffmpeg -c:v libvpx-vp9 -i a.webm -vf premultiply=inplace=1" in note for note in reader.notes)
    else:
        assert (read[:, 36:].max(), reader.notes) == (0, ["what is transparent in the video is black"])


def test_garbage_is_no_video(tmp_path: Path) -> None:
    (tmp_path / "cam00.mp4").write_bytes(b"not a video" * 100)
    with pytest.raises(InputError, match=r"cam00\.mp4: the video is unreadable"):
        VideoReader(tmp_path / "cam00.mp4")


def test_truncated_video_is_refused_when_opened(video: Path) -> None:
    video.write_bytes(video.read_bytes()[:-400])
    with pytest.raises(InputError, match=r"cam00\.mp4: .*(truncated|unreadable)"):
        VideoReader(video)


def test_truncated_video_with_its_header_in_front(sample: Path, tmp_path: Path) -> None:
    path = tmp_path / "cam00.mp4"
    with (
        av.open(str(sample / "cam00.mp4")) as source,
        av.open(str(path), "w", options={"movflags": "faststart"}) as target,
    ):
        stream = target.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                target.mux(packet)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(InputError, match=r"truncated: \d+ of 60 frames"):
        VideoReader(path)


@pytest.mark.parametrize(("first", "count"), [(0, 8), (4, 8), (4, 16), (7, 3)])
def test_a_clip_that_was_trimmed_without_encoding_has_the_frames_that_players_show(
    video: Path, first: int, count: int
) -> None:
    """QuickTime and phones keep all frames, and an edit list says which are shown."""
    data = bytearray(video.read_bytes())
    edit = data.index(b"elst") + 12  # its first entry: duration, and the time in the medium
    (tick,) = struct.unpack_from(">I", data, data.index(b"mdhd") + 16)
    (film,) = struct.unpack_from(">I", data, data.index(b"mvhd") + 16)
    (begin,) = struct.unpack_from(">i", data, edit + 4)
    struct.pack_into(">Ii", data, edit, film * count // 30, begin + tick * first // 30)
    video.write_bytes(data)
    reader = VideoReader(video)
    shown = [level(reader.read(index, 0)[0]) for index in (*range(len(reader)), 0, len(reader) - 1)]
    assert shown == [*LEVELS[first : first + count], LEVELS[first], LEVELS[first + count - 1]]
    np.testing.assert_allclose(reader.seconds, np.arange(count) / 30, atol=1e-3)


def test_damage_inside_a_video_is_an_error_not_a_guess(sample: Path, tmp_path: Path) -> None:
    damaged = bytearray((sample / "cam00.mp4").read_bytes())
    for place in range(300_000, 340_000):
        damaged[place] ^= 0x5A
    path = tmp_path / "cam00.mp4"
    path.write_bytes(damaged)
    reader = VideoReader(path)
    reader.read(0, 0)
    with pytest.raises(InputError, match=r"cam00\.mp4: frame \d+ is (unreadable|damaged)"):
        [reader.read(index, 0) for index in range(len(reader))]


def test_file_without_a_video_stream(tmp_path: Path) -> None:
    path = tmp_path / "cam00.mp4"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("aac", rate=44100)
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 2048), np.float32), format="fltp", layout="mono")
        frame.sample_rate = 44100
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    with pytest.raises(InputError, match="no video stream"):
        VideoReader(path)


def test_frames_of_a_file_without_an_index_come_in_every_order(tmp_path: Path) -> None:
    """MPEG-PS has no index, and FFmpeg, which looks for a time in it, may find a later one."""
    path = tmp_path / "cam00.mpg"
    noise = np.random.default_rng(0).integers(-9, 10, (192, 256, 3))  # packets longer than a pack
    with av.open(str(path), "w", format="mpeg") as container:
        stream = container.add_stream("mpeg2video", rate=25, options={"g": "6", "b": "3M"})
        stream.width, stream.height, stream.pix_fmt = 256, 192, "yuv420p"
        for value in LEVELS:
            picture = (value + noise).astype(np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode())
    order = (0, 19, 7, 8, 6, 5, 18, 12, 12, 0)
    reader = VideoReader(path)
    assert [level(reader.read(index, 0)[0]) for index in order] == [LEVELS[index] for index in order]
