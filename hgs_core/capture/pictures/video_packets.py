"""A video without its pictures: when each frame is shown, where decoding may begin, and how the file has it shown."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from hgs_core.base.errors import InputError
from hgs_core.capture.files.container import is_bare, open_container
from hgs_core.capture.files.encoding_again import encode_again
from hgs_core.capture.files.unreadable import unreadable
from hgs_core.capture.pictures.frame_display import FrameDisplay
from hgs_core.capture.pictures.video_stream import stated_rate, video_stream

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.video.stream import VideoStream

__all__ = ["VideoPackets", "open_stream"]

_LARGEST_ASPECT = 4  # times as wide as high, or as high as wide; anamorphic lenses double
_CURE = "copy or export the camera's video again"
_WITH_ALPHA = {"vp8": "libvpx", "vp9": "libvpx-vp9"}  # FFmpeg's decoders of transparency in WebM
_PROGRESSIVE = 1  # AVFieldOrder: 0 is unknown, from 2 on frames are of two fields


@dataclass
class VideoPackets:
    """The facts in the packets and the first frame of a video."""

    stream: int  # its index in the file
    size: tuple[int, int]  # width and height as stored, pixels
    rate: Fraction  # frames per second, as stated
    tick: Fraction  # unit of the stamps, seconds
    counted: bool  # whether stamps are the frames' numbers: the file does not store when one is shown
    timecode: str | None  # time code of the first frame
    aspect: Fraction  # width of a pixel by its height
    interlaced: bool  # whether frames are said to be two fields, half a period apart
    stamps: list[int] = field(default_factory=list)  # one for each frame, in the order shown
    keys: list[int] = field(default_factory=list)  # stamps at which decoding may begin
    display: FrameDisplay | None = None  # None: no frame can be decoded
    notes: list[str] = field(default_factory=list)  # choices, for people

    @classmethod
    def of(cls, path: Path) -> VideoPackets:
        """Read all packets of a file, and decode its first frame.

        Raises:
            InputError: the file is missing, no video, truncated or damaged, or its frames cannot be told apart.
        """
        import av

        if not path.is_file():
            raise InputError(path, "the video is missing", "restore the file")
        try:
            with open_container(path) as container:
                stream, said = open_stream(path, container)
                context = stream.codec_context
                context.thread_count = 1
                bare = is_bare(container)
                found = cls(
                    stream.index,
                    (context.width, context.height),
                    stated_rate(container, stream),
                    Fraction(stream.time_base or 0),
                    # AVI and bare streams do not store when a frame is shown: frames come in the decoder's order.
                    bare or container.format.name == "avi",
                    _tag(stream.metadata, "timecode") or _tag(container.metadata, "timecode"),
                    Fraction(stream.sample_aspect_ratio or 1),
                    context.field_order > _PROGRESSIVE,
                    notes=[said] if said else [],
                )
                # Of frames that an edit list cuts, the index has few; a truncated file has the whole index.
                indexed = len(stream.index_entries)
                announced = 0 if found.counted else min(stream.frames, indexed or stream.frames)
                cut, damaged = found._read(container, stream, bare)
                decoder = _WITH_ALPHA.get(context.name)
                if decoder is not None and _tag(stream.metadata, "alpha_mode") == "1":
                    on_black = "-vf premultiply=inplace=1 -pix_fmt yuv420p -c:v libx264 -crf 12"
                    cure = encode_again(path, reading=f"-c:v {decoder}", writing=on_black)
                    found.notes.append(f"what is transparent in the video is taken as stored; black it is by {cure}")
        except (av.FFmpegError, OSError) as error:
            raise unreadable(path, error, _CURE, "the video is unreadable") from error
        if bare and found.rate:
            rate = f"{float(found.rate):.5g} frames a second"
            found.notes.append(f"the file has no time stamps, and its stream says {rate}: these count")
        if not 1 / _LARGEST_ASPECT <= found.aspect <= _LARGEST_ASPECT:
            found.notes.append(f"pixels of {found.aspect} are no camera's, and taken to be square")
            found.aspect = Fraction(1)
        found._check(path, announced - cut, damaged)
        found.stamps.sort()
        found.keys = [found.stamps[0]] if found.counted else sorted({found.stamps[0], *found.keys})
        return found

    def _read(self, container: InputContainer, stream: VideoStream, bare: bool) -> tuple[int, bool]:
        """Read the stamps, in the order of the file; return the frames that an edit cut, and whether one is damaged."""
        cut, damaged = 0, False
        for packet in container.demux(stream):
            if self.display is None and (frames := stream.codec_context.decode(packet)):
                self.display = FrameDisplay.of(frames[0], self.size)
                self.interlaced |= any(frame.interlaced_frame for frame in frames)
            if packet.is_discard or not packet.size:
                cut += packet.is_discard
                continue
            if packet.pts is None and not self.stamps:
                self.counted = True
            stamp = packet.pts if not self.counted else None if bare else packet.dts
            if stamp is None:
                if not self.counted:
                    continue
                stamp = len(self.stamps)
                self.tick = 1 / self.rate if self.rate else Fraction(0)
            self.stamps.append(stamp)
            if packet.is_keyframe:
                self.keys.append(stamp)
            damaged |= packet.is_corrupt
        return cut, damaged

    def _check(self, path: Path, announced: int, damaged: bool) -> None:
        if not self.stamps:
            raise InputError(path, "the video has no frame", "export the camera's video again")
        if announced and len(self.stamps) < announced:
            problem = f"the video is truncated: {len(self.stamps)} of {announced} frames are there"
            raise InputError(path, problem, "copy the file again")
        if damaged:
            raise InputError(path, "the video holds damaged packets", "copy or export the camera's video again")
        if len(set(self.stamps)) < len(self.stamps):
            raise InputError(path, "two frames have the same time stamp", f"give them others: {encode_again(path)}")
        if self.rate <= 0:
            cure = f"say at how many it was filmed, such as 30: {encode_again(path, reading='-framerate 30')}"
            raise InputError(path, "the video does not state its frames per second", cure)
        if self.display is None:
            raise InputError(path, "no frame can be decoded", "export the camera's video again")


def _tag(tags: Mapping[str, str], called: str) -> str | None:
    """Return the value of a tag; Matroska writes names in capitals."""
    return next((value for name, value in tags.items() if name.casefold() == called), None)


def open_stream(path: Path, container: InputContainer) -> tuple[VideoStream, str]:
    """Return the camera's stream in an open file, and notes on others.

    Raises:
        InputError: there is none, or more than one.
    """
    stream, said = video_stream(path, container)
    if stream is None:
        raise InputError(path, "the file has no video stream", "export the camera's video again")
    return stream, said
