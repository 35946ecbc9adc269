"""Only files that hold their own pictures and sound are opened, under any name."""

from __future__ import annotations

import ast
import io
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import cast

import av
import numpy as np
import pytest
from PIL import Image

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import open_container
from hgs_core.capture.pictures.announced_length import announced_length
from hgs_core.capture.pictures.video import VideoReader
from hgs_core.capture.sound.sound_pieces import cut_sound
from hgs_core.capture.sound.sound_track import has_sound, read_sound, sound_begin
from tests.conftest import REPOSITORY

LISTS = {
    "ffconcat": b"ffconcat version 1.0\nfile 'cam0.mp4'\n",
    "ffconcat after a byte order mark": b"\xef\xbb\xbfffconcat version 1.0\nfile 'cam0.mp4'\n",
    "HLS": b"#EXTM3U\n#EXT-X-VERSION:3\n#EXT-X-TARGETDURATION:2\n#EXTINF:2.0,\ncam0.mp4\n#EXT-X-ENDLIST\n",
    "DASH": b"<?xml version='1.0'?>\n<!-- a -->\n<MPD xmlns='urn:mpeg:dash:schema:mpd:2011'></MPD>\n",
    "IMF": b"<?xml version='1.0'?><CompositionPlaylist></CompositionPlaylist>",
    "SDP": b"v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\nm=video 5000 RTP/AVP 96\r\n",
    "PLS": b"[playlist]\nFile1=cam0.mp4\n",
    "Windows Media": b"<ASX version='3.0'><entry><ref href='cam0.mp4'/></entry></ASX>",
    "a picture": b"\x89PNG\r\n\x1a\n",
    "GIF": b"GIF89a",
}
OTHERS = {
    "subtitles": b"1\n00:00:00,000 --> 00:00:09,000\nHello\n\n2\n00:00:10,000 --> 00:00:19,000\nHello\n",
    "ssa": b"[Script Info]\nScriptType: v4.00+\n[Events]\n",
    "webvtt": b"WEBVTT\n\n00:00.000 --> 00:01.000\nHello\n",
    "metadata": b";FFMETADATA1\ntitle=a\n",
    "text": b"nothing of the kind\n" * 40,
    "nothing": b"",
    "zeros": bytes(10_000),
}
PIXELS = {"mjpeg": "yuvj420p"}


@pytest.fixture(autouse=True)
def usual_scheduling() -> Iterator[None]:
    """Undo SVT-AV1's scheduling: it makes the encoding process, and all it starts, real-time."""
    yield
    if hasattr(os, "sched_setscheduler"):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


@pytest.mark.parametrize("name", [*LISTS, *OTHERS])
def test_a_list_of_files_and_what_is_no_container_are_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / "cam0.mp4"
    path.write_bytes((LISTS | OTHERS)[name])
    for look in (VideoReader, announced_length, read_sound, sound_begin, lambda file: cut_sound(file, 0.0, 1.0)):
        with pytest.raises(InputError, match=r"cam0\.mp4: ") as refusal:
            look(path)
        assert refusal.value.cure
    assert not has_sound(path)


@pytest.mark.parametrize("name", LISTS)
def test_a_list_of_files_is_called_so_with_a_cure_of_its_own(tmp_path: Path, name: str) -> None:
    path = tmp_path / "cam0.mp4"
    path.write_bytes(LISTS[name])
    with pytest.raises(InputError, match=r"not a video or sound of its own; .*"):
        open_container(path)


def write(path: Path, *, codec: str = "libx264", container: str | None = None) -> Path:
    with av.open(str(path), "w", format=container) as file:
        stream = cast("av.VideoStream", file.add_stream(codec, rate=25))
        stream.width, stream.height, stream.pix_fmt = 64, 48, PIXELS.get(codec, "yuv420p")
        for level in range(40, 200, 20):
            picture = np.full((48, 64, 3), level, np.uint8)
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        file.mux(stream.encode())
    return path


@pytest.mark.parametrize(
    ("ending", "codec", "container"),
    [
        ("mp4", "libx264", None),
        ("mov", "libx264", None),
        ("mkv", "libx264", None),
        ("webm", "libvpx", None),
        ("avi", "mpeg4", None),
        ("ts", "libx264", "mpegts"),
        ("mpg", "mpeg2video", "mpeg"),
        ("vob", "mpeg2video", "vob"),
        ("m2v", "mpeg2video", "mpeg2video"),
        ("mxf", "mpeg2video", "mxf"),
        ("flv", "flv", None),
        ("wmv", "wmv2", "asf"),
        ("ogv", "libtheora", "ogg"),
        ("nut", "mpeg4", "nut"),
        ("ivf", "libvpx", "ivf"),
        ("h264", "libx264", "h264"),
        ("h265", "libx265", "hevc"),
        ("obu", "libsvtav1", "obu"),
        ("y4m", "wrapped_avframe", "yuv4mpegpipe"),
        ("mjpeg", "mjpeg", "mjpeg"),
    ],
)
def test_videos_of_every_usual_container_are_read(
    tmp_path: Path, ending: str, codec: str, container: str | None
) -> None:
    if codec not in av.codecs_available:
        pytest.skip(f"this FFmpeg cannot write {codec}")
    path = write(tmp_path / f"take:2 %03d.{ending}", codec=codec, container=container)
    with open_container(path) as opened:
        assert sum(1 for _ in opened.decode(video=0)) == 8


def test_a_stream_of_large_jpeg_pictures_is_read_to_its_end(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 256, (1200, 1600, 3)).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(noise).save(file, "JPEG", quality=95)
    (tmp_path / "a.mjpeg").write_bytes(file.getvalue() * 3)
    with open_container(tmp_path / "a.mjpeg") as opened:
        assert sum(1 for _ in opened.demux(video=0) if _.size) == 3


@pytest.mark.parametrize(
    ("ending", "codec"),
    [("wav", "pcm_s16le"), ("flac", "flac"), ("m4a", "aac"), ("aac", "aac"), ("ogg", "libopus"), ("mp3", "libmp3lame")],
)
def test_sound_of_every_usual_container_is_read(tmp_path: Path, ending: str, codec: str) -> None:
    if codec not in av.codecs_available:
        pytest.skip(f"this FFmpeg cannot write {codec}")
    path = tmp_path / f"a.{ending}"
    with av.open(str(path), "w") as container:
        stream = cast("av.AudioStream", container.add_stream(codec, rate=48_000, layout="mono"))
        resampler = av.AudioResampler(stream.format, "mono", 48_000, 960)
        levels = np.random.default_rng(0).integers(-9000, 9000, (1, 48_000)).astype(np.int16)
        frame = av.AudioFrame.from_ndarray(levels, format="s16", layout="mono")
        frame.sample_rate, frame.pts = 48_000, 0
        for part in [*resampler.resample(frame), *resampler.resample(None)]:
            container.mux(stream.encode(part))
        container.mux(stream.encode())
    assert has_sound(path)
    sound = read_sound(path)
    assert sound is not None
    assert abs(len(sound) - 16_000) < 2_000


@pytest.mark.parametrize(
    "name", ["concat:cam0.mp4|cam0.mp4", "subfile,,start,0,end,0,,:cam0.mp4", "http:cam0.mp4", "data:text", "pipe:0"]
)
def test_no_name_of_a_file_is_taken_for_a_protocol(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "cam0.mp4")
    with pytest.raises(InputError, match="no such file"):
        open_container(Path(name))


def test_no_name_of_a_file_is_taken_for_a_pattern(tmp_path: Path) -> None:
    write(tmp_path / "001.mp4")
    with pytest.raises(InputError, match="no such file"):
        open_container(tmp_path / "%03d.mp4")


@pytest.mark.parametrize("kind", [b"url ", b"alis"])
def test_a_reference_movie_does_not_lead_to_another_file(tmp_path: Path, kind: bytes) -> None:
    """QuickTime tracks may say that their samples lie in another file: FFmpeg is not to go there."""
    whole = write(tmp_path / "whole.mov").read_bytes()
    other = b"file:whole.mov\0" if kind == b"url " else b"\0" * 150
    entry = struct.pack(">I4sI", 12 + len(other), kind, 0) + other
    place = whole.index(b"dref") - 4
    size = struct.unpack(">I", whole[place : place + 4])[0]
    reference = bytearray(whole[:place] + struct.pack(">I4sII", 16 + len(entry), b"dref", 0, 1) + entry)
    reference += whole[place + size :]
    grown = 16 + len(entry) - size
    for box in (b"moov", b"trak", b"mdia", b"minf", b"dinf"):
        at = reference.rindex(box, 0, place) - 4
        reference[at : at + 4] = struct.pack(">I", struct.unpack(">I", reference[at : at + 4])[0] + grown)
    reference[reference.index(b"mdat") : reference.index(b"mdat") + 4] = b"free"
    start = reference.index(b"free", reference.index(b"ftyp") + 20) + 4
    reference[start : whole.index(b"moov") - 4] = bytes(whole.index(b"moov") - 4 - start)  # no sample of its own
    (tmp_path / "reference.mov").write_bytes(bytes(reference))
    with pytest.raises(InputError, match=r"reference\.mov"):
        VideoReader(tmp_path / "reference.mov")


def test_nothing_else_opens_media() -> None:
    """`av.open` is called in one module, so that its list of containers holds everywhere; readers note its calls."""
    callers = {
        path.relative_to(REPOSITORY).as_posix()
        for package in ("hgs_core", "jobs", "server")
        for path in (REPOSITORY / package).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Attribute)
        and (isinstance(node.value, ast.Name) and (node.value.id, node.attr) == ("av", "open"))
    }
    assert callers == {"hgs_core/capture/files/container.py", "server/captures/capture_reader.py"}
