"""Frames of one video file by number, decoded with PyAV (FFmpeg)."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from hgs_core.base.errors import InputError
from hgs_core.capture.cache import Neighbour
from hgs_core.capture.container import open_container
from hgs_core.capture.display_matrix import quarter_turns
from hgs_core.capture.unreadable import unreadable
from hgs_core.capture.wide_colours import wide_colours_of

if TYPE_CHECKING:
    import av

__all__ = ["VideoReader", "announced_length"]


def announced_length(path: Path) -> tuple[int | None, float | None]:
    """Return the number of frames and the frames per second that the header of a video states; None where it does not.

    Raises:
        InputError: the file is missing or no video.
    """
    import av

    try:
        with open_container(path) as container:
            if not container.streams.video:
                raise InputError(path, "the file has no video stream", "export the camera's video again")
            stream = container.streams.video[0]
            return stream.frames or None, float(stream.average_rate or 0) or None
    except (av.FFmpegError, OSError) as error:
        raise unreadable(path, error, "copy or export it again", "the video is unreadable") from error


class VideoReader:
    """Random access to the frames of a video.

    The decoder stays open and runs forward while that is the shortest way to the next frame asked for; otherwise it
    seeks to the key frame before it. Pictures are upright, as players show them: turned as the file's display matrix
    says, and `width` and `height` are theirs. Wide colours and high dynamic range are brought to BT.709. Not safe for
    several threads at once.
    """

    def __init__(self, path: Path) -> None:
        """Read the packets' time stamps, and the display matrix, which comes with the first frame.

        Raises:
            InputError: the file is missing, no video, truncated, its frames cannot be told apart, or are to be shown
                mirrored or tilted.
        """
        import av
        from av.video.reformatter import VideoReformatter

        self.path = path
        if path.is_file():
            self.files = [(path, path.stat().st_size)]
        else:
            raise InputError(path, "the video is missing", "restore the file")
        stamps: list[int] = []
        keys: list[int] = []
        shown: list[av.VideoFrame] = []  # the first that the decoder gives
        try:
            with open_container(path) as container:
                if not container.streams.video:
                    raise InputError(path, "the file has no video stream", "export the camera's video again")
                stream = container.streams.video[0]
                context = stream.codec_context
                context.thread_count = 1
                self.width, self.height = context.width, context.height
                self.rate: Fraction = Fraction(stream.average_rate or 0)
                self._tick = Fraction(stream.time_base or 0)
                self.timecode = stream.metadata.get("timecode") or container.metadata.get("timecode")
                # AVI and bare streams do not store when a frame is shown: frames are counted as the decoder gives them.
                self._counted = container.format.name == "avi"
                announced = 0 if self._counted else stream.frames
                damaged = False
                for packet in container.demux(stream):
                    if not shown:
                        shown = context.decode(packet)
                    if packet.is_discard or not packet.size:
                        continue
                    if packet.pts is None and not stamps:
                        self._counted = True
                    stamp = packet.dts if self._counted else packet.pts
                    if stamp is None:
                        if not self._counted:
                            continue
                        stamp = len(stamps)
                        self._tick = 1 / self.rate if self.rate else Fraction(0)
                    stamps.append(stamp)
                    if packet.is_keyframe:
                        keys.append(stamp)
                    damaged |= packet.is_corrupt
        except (av.FFmpegError, OSError) as error:
            raise self._unreadable(error) from error
        if not stamps:
            raise InputError(path, "the video has no frame", "export the camera's video again")
        if announced and len(stamps) < announced:
            problem = f"the video is truncated: {len(stamps)} of {announced} frames are there"
            raise InputError(path, problem, "copy the file again")
        if damaged:
            raise InputError(path, "the video holds damaged packets", "copy or export the camera's video again")
        if len(set(stamps)) < len(stamps):
            raise InputError(path, "two frames have the same time stamp", "export the camera's video again")
        if self.rate <= 0:
            raise InputError(path, "the video does not state its frame rate", "export the camera's video again")
        self._stamps = sorted(stamps)  # of the frames in the order shown
        self._keys = sorted(keys) if keys and not self._counted else [self._stamps[0]]
        self._container: av.container.InputContainer | None = None
        self._frames: Iterator[av.VideoFrame] | None = None
        self._next = 0  # the frame that the open decoder will give next
        self._reformatter = VideoReformatter()
        if not shown:
            raise InputError(path, "no frame can be decoded", "export the camera's video again")
        turns = quarter_turns(shown[0])
        if turns is None:
            raise InputError(path, "the video is to be shown mirrored or tilted", "export it as it should look")
        if turns % 2:
            self.width, self.height = self.height, self.width
        self._turns = turns
        self.wide_colours = wide_colours_of(shown[0])

    @property
    def seconds(self) -> npt.NDArray[np.float64]:
        """The time stamps of the frames [N], seconds; exact multiples of the period where they are rounded ones."""
        stamps = np.array([float(stamp * self._tick) for stamp in self._stamps])
        even = stamps[0] + np.arange(len(stamps)) / float(self.rate)
        return even if np.abs(stamps - even).max() <= self.resolution else stamps

    @property
    def frame_rate(self) -> float:
        """Frames per second: as the file states it, unless its time stamps say otherwise; then their mean."""
        seconds = self.seconds
        if len(seconds) < 2 or abs((seconds[-1] - seconds[0]) * float(self.rate) - len(seconds) + 1) < 0.5:
            return float(self.rate)
        return (len(seconds) - 1) / float(seconds[-1] - seconds[0])

    @property
    def resolution(self) -> float:
        """The unit of the file's time stamps, seconds."""
        return float(self._tick)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self._stamps)

    def read(self, index: int, neighbours: int) -> tuple[npt.NDArray[np.uint8], list[Neighbour]]:
        """Return frame `index` [H, W, 3], and the last `neighbours` frames that were decoded on the way to it.

        Raises:
            InputError: the video is damaged.
        """
        import av

        key = self._stamps.index(self._keys[max(0, bisect_right(self._keys, self._stamps[index]) - 1)])
        passed: list[Neighbour] = []
        try:
            # Frames that the caller keeps on the way are worth decoding, even where a key frame would skip them.
            if self._frames is None or self._next > index or key - self._next > neighbours:
                self._seek(key)
            start = self._next
            assert self._frames is not None
            for frame in self._frames:
                shown = self._index(frame)
                if shown is None or shown < start:
                    continue  # a leading frame after a seek may refer to pictures before the key frame
                if frame.is_corrupt:
                    raise InputError(self.path, f"frame {shown} is damaged", "export the camera's video again")
                self._next = shown + 1
                if shown == index:
                    return self._picture(frame), passed
                if shown > index:
                    break
                if index - shown <= neighbours:
                    passed.append((shown, self._picture(frame)))
        except (av.FFmpegError, OSError) as error:
            self._close()
            raise self._unreadable(error, index) from error
        self._close()
        raise InputError(self.path, f"frame {index} cannot be decoded", "export the camera's video again")

    def _seek(self, key: int) -> None:

        if self._counted:
            self._close()
        if self._container is None:
            self._container = open_container(self.path)
            context = self._container.streams.video[0].codec_context
            context.thread_count = 1  # frame threads would hold several pictures for each of many cameras
            context.options = {"err_detect": "explode"}  # damage is an error, never a guessed picture
        stream = self._container.streams.video[0]
        if not self._counted:
            self._container.seek(self._stamps[key], stream=stream, backward=True)
        self._frames = self._container.decode(stream)
        self._next = key

    def _close(self) -> None:
        if self._container is not None:
            self._container.close()
        self._container = self._frames = None

    def _index(self, frame: av.VideoFrame) -> int | None:
        """Return the number of a decoded frame."""
        if self._counted:
            return self._next
        if frame.pts is None:
            return None
        index = bisect_left(self._stamps, frame.pts)
        return index if index < len(self._stamps) and self._stamps[index] == frame.pts else None

    def _picture(self, frame: av.VideoFrame) -> npt.NDArray[np.uint8]:
        from av.video.reformatter import ColorPrimaries, Colorspace, Interpolation

        # Without these flags chroma of half resolution is repeated instead of interpolated, and sums are cut off.
        best = Interpolation.BICUBIC | Interpolation.FULL_CHR_H_INT | Interpolation.FULL_CHR_H_INP
        best |= Interpolation.ACCURATE_RND
        if self.wide_colours is not None:
            matrix = Colorspace.BT2020 if self.wide_colours.primaries == ColorPrimaries.BT2020 else None
            deep = self._reformatter.reformat(
                frame, format="rgb48le", interpolation=best, threads=1, src_colorspace=matrix,
            )  # fmt: skip
            return np.ascontiguousarray(
                np.rot90(self.wide_colours.shown(np.asarray(deep.to_ndarray(), np.uint16)), self._turns)
            )
        picture = self._reformatter.reformat(frame, format="rgb24", interpolation=best, threads=1).to_ndarray()
        return np.ascontiguousarray(np.rot90(picture, self._turns))

    def _unreadable(self, error: Exception, index: int | None = None) -> InputError:
        what = "the video" if index is None else f"frame {index}"
        return unreadable(self.path, error, "copy or export the camera's video again", f"{what} is unreadable")
