"""The one door to videos and sound: containers that hold their own data, and nothing that leads elsewhere.

FFmpeg opens whatever a file says it is: a list of other files (ffconcat, HLS, DASH, SDP), names with a protocol or a
pattern in them, a text as pictures. A list that names itself ends the process, and one of 24 KB is minutes of work. So
only demuxers of this module's list are tried, files are named by their whole path, and no protocol but `file` is there.
"""

from __future__ import annotations

import io
import re
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from hgs_core.base.errors import InputError

if TYPE_CHECKING:
    from av.container import InputContainer, OutputContainer

__all__ = ["is_bare", "new_container", "open_container", "open_sound_piece"]

_STAMPED = "mov matroska avi mpegts mpeg mxf flv ogg asf rm gxf lxf dv nut ivf yuv4mpegpipe"
_BARE = "h264 hevc vvc obu av1 mpegvideo m4v h263 vc1 mjpeg"
_SOUND = "wav w64 aiff caf au mp3 flac aac ac3 eac3 amr wv ape"
_OPTIONS = {"format_whitelist": f"{_STAMPED} {_BARE} {_SOUND}".replace(" ", ","), "protocol_whitelist": "file"}
_HEAD_BYTES = 4096
_JPEG = b"\xff\xd8\xff"
_JOINED = "put a video in its place, as this makes of its parts: ffmpeg -f {} -i {} -c copy NEW.mp4"
_ELSEWHERE = "put the video itself in its place"
_LISTS = (  # files that lead to others, or are none: how each begins, what it is, and the way out
    (re.compile(rb"ffconcat\s"), "a list of other files (ffconcat)", _JOINED.format("concat -safe 0", "{}")),
    (re.compile(rb"#EXTM3U"), "a playlist (HLS)", _JOINED.format("hls -allowed_extensions ALL", "{}")),
    (re.compile(rb"<(.*<)?MPD\b", re.DOTALL), "a playlist (DASH)", _JOINED.format("dash", "{}")),
    (re.compile(rb"<(.*[<:])?CompositionPlaylist\b", re.DOTALL), "a playlist (IMF)", _ELSEWHERE),
    (re.compile(rb"\[playlist\]", re.IGNORECASE), "a playlist (PLS)", _ELSEWHERE),
    (re.compile(rb"<ASX\b|\[Reference\]|ASF ", re.IGNORECASE), "a playlist (Windows Media)", _ELSEWHERE),
    (re.compile(rb"v=0\s"), "a description of a stream (SDP)", _ELSEWHERE),
    (re.compile(rb"\x89PNG|GIF8|RIFF....WEBP", re.DOTALL), "a picture", _ELSEWHERE),
)


def open_container(path: Path) -> InputContainer:
    """Return an open video or sound file; the caller closes it.

    Raises:
        InputError: there is no such file, or it is no container that holds its own pictures and sound.
        av.FFmpegError: the container is damaged.
        OSError: it may not be read.
    """
    import av

    if not path.is_file():
        raise InputError(path, "there is no such file", "restore the file")
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    text = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    for begins, what, cure in _LISTS:
        if begins.match(text):
            problem = f"is {what}, not a video or sound of its own"
            raise InputError(path, problem, cure.format(shlex.quote(str(path))))
    try:
        # The protocol goes before the path: of "take:2.mp4" FFmpeg would ask for a protocol called take.
        # Of large pictures in a row FFmpeg would see the first alone, and take the file for a photograph.
        demuxer = "mjpeg" if head.startswith(_JPEG) else None
        return av.open(f"file:{path.absolute()}", format=demuxer, options=dict(_OPTIONS), metadata_errors="replace")
    except av.error.ArgumentError as error:
        problem = "is in none of the formats that videos and sound are read from"
        raise InputError(path, problem, f"export it as MP4: ffmpeg -i {shlex.quote(str(path))} NEW.mp4") from error


def open_sound_piece(data: bytes, form: str) -> InputContainer:
    """Return an open piece of a scene's sound; the caller closes it.

    Args:
        data: whole file.
        form: its demuxer, "ogg" or "aac"; no other is tried.

    Raises:
        av.FFmpegError: the data are of another format, or damaged.
    """
    import av

    return av.open(io.BytesIO(data), "r", format=form, options={"protocol_whitelist": ""})


def new_container(path: Path, form: str, options: Mapping[str, str]) -> OutputContainer:
    """Return a new video file, open for writing by the muxer `form`; the caller closes it.

    Raises:
        OSError: it cannot be written.
    """
    import av

    return av.open(f"file:{path.absolute()}", "w", format=form, options=dict(options))


def is_bare(container: InputContainer) -> bool:
    """Return whether a file is a stream without a container: FFmpeg makes up its time stamps, 25 frames a second."""
    return container.format.name in _BARE.split()
